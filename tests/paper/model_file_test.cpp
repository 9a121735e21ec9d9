// Models on disk are loaded whole or refused.
#include "paper/model/model_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/storage/crc64.hpp"
#include "paper/train.hpp"

namespace slipd {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

ModelSetup small_setup() {
  Scene scene;
  scene.objects = paper_objects();
  scene.noise = 0.01;
  return {TaxelLayout::grid(8, 8, 1.8e-3), scene, {.contacts = 20, .loads = 5}, 3, 4, 3};
}

const ModelData& small_model() {
  static const ModelData data = train(small_setup());
  return data;
}

class ModelFile : public ::testing::Test {
 protected:
  void SetUp() override { fs::remove_all(folder_); }
  void TearDown() override { fs::remove_all(folder_); }
  const fs::path folder_ = fs::temp_directory_path() / ("slipd-model-test-" + std::to_string(::getpid()));
};

std::string why_refused(std::span<const std::uint8_t> bytes) {
  try {
    decode_model(bytes);
  } catch (const ModelError& error) {
    return error.what();
  }
  return "";
}

TEST_F(ModelFile, KeepsTheExpectedErrorOfEachMethod) {
  ModelData data = small_model();
  TradeoffRow row;
  row.method = "registered";
  row.settings = {3, 16, 5, Precision::single_precision, 12345};
  row.mean_error = 0.01;
  row.p99_us = 7;
  data.work_precision = {{row}, "a processor"};
  const WorkPrecision work_precision = decode_model(encode_model(data)).data().work_precision;
  ASSERT_EQ(work_precision.rows.size(), 1U);
  EXPECT_EQ(work_precision.processor, "a processor");
  EXPECT_EQ(work_precision.rows[0].method, "registered");
  EXPECT_EQ(work_precision.rows[0].settings.memory_bytes, 12345U);
  EXPECT_EQ(work_precision.rows[0].settings.precision, Precision::single_precision);
  EXPECT_EQ(work_precision.rows[0].mean_error, 0.01);
  EXPECT_EQ(work_precision.rows[0].p99_us, 7);
}

TEST_F(ModelFile, ComesBackAsItWas) {
  const Model model = decode_model(encode_model(small_model()));
  EXPECT_EQ(model.setup(), small_setup());
  EXPECT_EQ(model.data().basis, small_model().basis);
  EXPECT_EQ(model.data().coordinates, small_model().coordinates);
  EXPECT_EQ(model.data().gamma, small_model().gamma);
  EXPECT_EQ(model.data().friction, small_model().friction);
  EXPECT_EQ(model.data().singular_values, small_model().singular_values);
  EXPECT_EQ(model.data().errors.gamma, small_model().errors.gamma);
  EXPECT_EQ(model.data().errors.distance_limit, small_model().errors.distance_limit);
  EXPECT_EQ(encode_model(model.data()), encode_model(small_model()));
}

TEST_F(ModelFile, FlatSkinsAndScatteredTaxelsSurvive) {
  ModelData data = small_model();
  data.setup.scene.skin.radius_m = std::numeric_limits<double>::infinity();
  data.setup.layout = TaxelLayout::scattered({0, 1e-3, 2.5e-3}, {0, 0, 1e-3});
  data.basis.resize(3 * data.singular_values.size());
  EXPECT_EQ(decode_model(encode_model(data)).setup(), data.setup);
}

TEST_F(ModelFile, EveryDamagedByteIsRefused) {
  auto bytes = encode_model(small_model());
  for (std::size_t at = 0; at < bytes.size(); at += at < 100 ? 1 : 53) {
    for (const std::uint8_t flip : {0x01, 0x80}) {
      bytes[at] ^= flip;
      EXPECT_NE(why_refused(bytes), "") << "byte " << at;
      bytes[at] ^= flip;
    }
  }
}

TEST_F(ModelFile, EveryTruncatedFileIsRefused) {
  const auto bytes = encode_model(small_model());
  for (std::size_t length = 0; length < bytes.size(); length += length < 100 ? 1 : 211) {
    EXPECT_NE(why_refused(std::span(bytes).first(length)), "") << length << " bytes";
  }
}

TEST_F(ModelFile, AnotherVersionAndAForeignFileAreNamed) {
  auto other = nlohmann::json::from_cbor(encode_model(small_model()));
  other["version"] = kModelVersion + 1;
  EXPECT_THAT(why_refused(nlohmann::json::to_cbor(other)),
              HasSubstr("version " + std::to_string(kModelVersion + 1)));
  EXPECT_THAT(why_refused(nlohmann::json::to_cbor({{"format", "holiday-pictures"}})),
              HasSubstr("no slipd model"));
}

TEST_F(ModelFile, AModelOfAnotherSetupIsNotUsed) {
  ModelSetup other = small_setup();
  other.seed = 4;
  save_model(small_model(), model_cache_file(other, folder_));
  EXPECT_THROW(load_cached_model(other, folder_), ModelError);
  save_model(small_model(), model_cache_file(small_setup(), folder_));
  EXPECT_EQ(load_cached_model(small_setup(), folder_).setup(), small_setup());
}

TEST_F(ModelFile, DeepNestingIsRefusedBeforeItIsParsed) {
  const std::vector<std::uint8_t> deep(10'000'000, 0x81);  // a list in a list in a list …
  EXPECT_THAT(why_refused(deep), HasSubstr("no CBOR item"));
  const nlohmann::json sealed{{"format", "slipd-model"},
                              {"version", kModelVersion},
                              {"crc64", crc64(deep)},
                              {"body", nlohmann::json::binary(deep)}};
  EXPECT_THAT(why_refused(nlohmann::json::to_cbor(sealed)), HasSubstr("no CBOR item"));
}

TEST_F(ModelFile, IsNotReadFromALinkAPipeOrAFileThatOthersCanWrite) {
  const fs::path file = folder_ / "model.cbor";
  const auto refusal = [](const fs::path& of) -> std::string {
    try {
      load_model(of);
    } catch (const ModelError& error) {
      return error.what();
    }
    return "";
  };
  save_model(small_model(), file);
  EXPECT_EQ(refusal(file), "");
  fs::create_symlink(file, folder_ / "link.cbor");
  EXPECT_THAT(refusal(folder_ / "link.cbor"), HasSubstr("symbolic link"));
  ASSERT_EQ(::mkfifo((folder_ / "pipe.cbor").c_str(), 0600), 0);
  EXPECT_THAT(refusal(folder_ / "pipe.cbor"), HasSubstr("no regular file"));
  fs::permissions(file, fs::perms::others_write, fs::perm_options::add);
  EXPECT_THAT(refusal(file), HasSubstr("written by everybody"));
  fs::permissions(file, fs::perms::others_write, fs::perm_options::remove);
  if (::geteuid() != 0) return;  // only root can change the owner of a file
  ASSERT_EQ(::chown(file.c_str(), 12345, 12345), 0);
  EXPECT_THAT(refusal(file), HasSubstr("belongs to user 12345"));
}

TEST_F(ModelFile, IsNotWrittenThroughALinkInItsPlace) {
  fs::create_directories(folder_);
  const fs::path precious = folder_ / "precious";
  std::ofstream(precious) << "mine";
  const fs::path file = folder_ / "model.cbor";
  fs::create_symlink(precious, file.string() + ".new-" + std::to_string(::getpid()));
  fs::create_symlink(precious, file);
  save_model(small_model(), file);
  EXPECT_EQ(fs::file_size(precious), 4U);
  EXPECT_FALSE(fs::is_symlink(file));
  EXPECT_NO_THROW(load_model(file));
}

TEST_F(ModelFile, SavingLeavesNothingElseBehind) {
  const fs::path file = folder_ / "deep" / "model.cbor";
  save_model(small_model(), file);
  save_model(small_model(), file);
  EXPECT_EQ(std::distance(fs::directory_iterator(file.parent_path()), fs::directory_iterator()), 1);
}

TEST_F(ModelFile, ErrorsNameTheFile) {
  fs::create_directories(folder_);
  std::ofstream(folder_ / "broken.cbor") << "not a model";
  for (const char* name : {"broken.cbor", "missing.cbor"}) {
    try {
      load_model(folder_ / name);
      FAIL() << name;
    } catch (const ModelError& error) {
      EXPECT_THAT(error.what(), HasSubstr((folder_ / name).string()));
    }
  }
  // A folder cannot be made inside a file.
  EXPECT_THROW(save_model(small_model(), folder_ / "broken.cbor" / "model.cbor"), ModelError);
}

TEST_F(ModelFile, NamesDifferForSetupsThatDiffer) {
  const auto id = model_id(small_setup());
  EXPECT_EQ(id.size(), 16U);
  const auto changed = [](auto change) {
    ModelSetup setup = small_setup();
    change(setup);
    return model_id(setup);
  };
  EXPECT_EQ(id, model_id(small_setup()));
  EXPECT_NE(id, changed([](ModelSetup& s) { s.layout = TaxelLayout::grid(8, 8, 1.9e-3); }));
  EXPECT_NE(id, changed([](ModelSetup& s) { s.scene.noise = 0.02; }));
  EXPECT_NE(id, changed([](ModelSetup& s) { s.scene.objects[1].flat_share = 0.4; }));
  EXPECT_NE(id, changed([](ModelSetup& s) { s.rank = 5; }));
  EXPECT_NE(id, changed([](ModelSetup& s) { s.size.loads = 6; }));
}

TEST_F(ModelFile, AnInvalidModelWithAMatchingChecksumIsRefused) {
  const auto refused = [](auto change) {
    ModelData data = small_model();
    change(data);
    return why_refused(encode_model(data)) != "";
  };
  EXPECT_TRUE(refused([](ModelData& d) { d.gamma.pop_back(); }));
  EXPECT_TRUE(refused([](ModelData& d) { d.gamma[0] = 1.5F; }));
  EXPECT_TRUE(refused([](ModelData& d) { d.basis.resize(d.basis.size() - 1); }));
  EXPECT_TRUE(refused([](ModelData& d) { d.coordinates[3] = std::numeric_limits<float>::quiet_NaN(); }));
  EXPECT_TRUE(refused([](ModelData& d) { d.singular_values.clear(); }));
  EXPECT_TRUE(refused([](ModelData& d) { d.errors.spread_to[0] = 9; }));
}

}  // namespace
}  // namespace slipd
