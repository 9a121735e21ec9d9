// Recordings of real gels, beside the checkout where there are any: which share of the dots is found, how
// much a dot at rest wanders, and how long a picture takes. One number of the tracker was kept after a look
// at some of them (docs/camera.md), so they are no independent judge of it.
#include <gtest/gtest.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <limits>
#include <string>
#include <vector>

#include "camera/frames/gel_reader.hpp"
#include "camera/picture/video_file.hpp"
#include "camera/profile/profile.hpp"

namespace slipd::camera {
namespace {

// Every so many-th video, for the time of a test; odd, because cameras take turns.
constexpr std::size_t kEvery = 7;
constexpr std::size_t kRestPictures = 15;

using Course = std::vector<std::vector<SurfacePoint>>;  // by picture

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values.at(static_cast<std::size_t>(share * static_cast<double>(values.size() - 1)));
}

// Standard deviation along x of point `i` in the pictures from `first`, px; infinite if it is not always
// seen.
double wander(const Course& course, std::size_t first, std::size_t i) {
  double sum = 0, squares = 0;
  for (std::size_t at = first; at < first + kRestPictures; ++at) {
    if (!course[at][i].seen) return std::numeric_limits<double>::infinity();
    const double x = course[at][i].now.x - course[first][i].now.x;
    sum += x;
    squares += x * x;
  }
  return std::sqrt(std::max(0.0, squares / kRestPictures - sum * sum / (kRestPictures * kRestPictures)));
}

// The median dot's, in the quietest pictures.
double noise_at_rest(const Course& course, std::size_t points) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t first = 0; first + kRestPictures <= course.size(); first += kRestPictures) {
    std::vector<double> all;
    for (std::size_t i = 0; i < points; ++i) all.push_back(wander(course, first, i));
    least = std::min(least, quantile(all, 0.5));
  }
  return least;
}

struct Found {
  std::vector<double> shares, noises;
  double ms = 0;
};

void play(const std::string& video, Found& found) {
  Profile profile = load_profile("own-dots", std::filesystem::path(SLIPD_SOURCE_DIR) / "camera/profiles");
  GelReader reader(profile);
  VideoFile file(video, 1);
  Course course;
  while (const auto picture = file.next()) {
    const double before = cpu_ms();
    const bool read = !reader.read(*picture).empty();
    found.ms += cpu_ms() - before;
    if (read) course.push_back(reader.points());
  }
  ASSERT_FALSE(course.empty()) << video;
  const std::size_t points = course.front().size();
  for (const auto& picture : course) {
    const auto seen = std::count_if(picture.begin(), picture.begin() + static_cast<std::ptrdiff_t>(points),
                                    [](const SurfacePoint& point) { return point.seen; });
    found.shares.push_back(static_cast<double>(seen) / static_cast<double>(points));
  }
  if (course.size() >= kRestPictures) found.noises.push_back(noise_at_rest(course, points));
}

TEST(Recordings, have_nearly_all_dots_found_that_hardly_wander_at_rest) {
  const auto folder = std::filesystem::path(SLIPD_SOURCE_DIR) / "../shared/data/gelsight";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "there are no recordings in " << folder;
  std::vector<std::string> videos;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().extension() == ".avi") videos.push_back(entry.path());
  }
  std::sort(videos.begin(), videos.end());
  Found found;
  for (std::size_t i = 0; i < videos.size(); i += kEvery) play(videos[i], found);
  std::cout << found.shares.size()
            << " pictures: dots found in 99 % of them: " << quantile(found.shares, 0.01)
            << ", in 90 %: " << quantile(found.shares, 0.1) << "; noise at rest, px: median "
            << quantile(found.noises, 0.5) << ", largest " << quantile(found.noises, 1) << "; "
            << found.ms / static_cast<double>(found.shares.size()) << " ms of a processor each\n";
  EXPECT_GE(quantile(found.shares, 0.1), 0.9);
  EXPECT_LE(quantile(found.noises, 0.5), 0.05);
}

}  // namespace
}  // namespace slipd::camera
