#include "daemon/pipeline/estimator_factory.hpp"

#include <algorithm>
#include <iterator>
#include <new>
#include <utility>

#include "core/estimate/tradeoff.hpp"

namespace slipd {
namespace {

constexpr std::size_t kStackBytes = std::size_t{1024} * 1024;

}  // namespace

LaneMaker::LaneMaker(const Settings& settings, std::vector<std::unique_ptr<Seat>>& seats, LogRing& log,
                     Doorbell& estimate, ModelSource models)
    : settings_(settings), seats_(seats), log_(log), estimate_(estimate), models_(std::move(models)) {}

LaneMaker::~LaneMaker() = default;

void LaneMaker::start() {
  thread_ = Thread("set-up", kStackBytes, [this] { run(); });
}

void LaneMaker::ask_to_stop() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_one();
}

void LaneMaker::want(std::size_t sensor, std::shared_ptr<Feed> feed) {
  {
    const std::lock_guard lock(mutex_);
    jobs_.push_back({sensor, std::move(feed)});
  }
  changed_.notify_one();
}

void LaneMaker::run() {
  for (;;) {
    Job job;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return stop_ || !jobs_.empty(); });
      if (stop_) return;
      job = std::move(jobs_.front());
      jobs_.pop_front();
    }
    free_retired();
    try {
      make(job);
    } catch (const std::bad_alloc&) {  // not even to say what is wrong
      seats_[job.sensor]->refused.store(true, std::memory_order_relaxed);
      estimate_.ring();
    }
  }
}

void LaneMaker::make(const Job& job) {
  Seat& seat = *seats_[job.sensor];
  const Lane* lane = nullptr;
  try {
    lane = &lay(job, seat);
    seat.refused.store(false, std::memory_order_relaxed);
  } catch (const std::exception& error) {
    const std::string trouble = error.what();
    seat.panel.change_facts([&](DeviceFacts& facts) { facts.trouble = trouble; });
    seat.refused.store(true, std::memory_order_relaxed);
    log_.write(LogLevel::error, {seat.panel.name, Cause::configuration}, "%s: no estimator: %s",
               seat.panel.name.c_str(), trouble.c_str());
  }
  estimate_.ring();
  // What it is worth is good to know, but nothing waits for it.
  if (lane == nullptr || !lane->worth.rows.empty()) return;
  const Worth worth = measure_worth(lane->setup, lane->method);
  seat.panel.change_facts([&](DeviceFacts& facts) { facts.tradeoff = worth; });
}

const Lane& LaneMaker::lay(const Job& job, Seat& seat) {
  Scene scene = settings_.scene_of(seat.settings);
  if (const auto& skin = job.feed->info.skin) scene.skin = {skin->radius_m, skin->modulus_pa, skin->poisson};
  const ChainSetup setup{.layout = job.feed->info.layout,
                         .sensor_class = job.feed->info.sensor_class,
                         .scene = scene,
                         .estimator = settings_.estimator,
                         .alerts = settings_.alerts,
                         .friction = seat.settings.friction};
  std::optional<EstimatorChain> chain = inherited(seat, setup);
  const char* const past = chain ? ", with what it had learnt before the reload" : "";
  if (!chain) {
    std::shared_ptr<const Model> model;
    if (needs_model(setup)) model = models_(seat.panel.name, setup);
    chain.emplace(setup, std::move(model));
  }
  lanes_.push_back(std::make_unique<Lane>(job.sensor, job.feed, setup, std::move(*chain)));
  Lane* const lane = lanes_.back().get();
  const std::string method(to_string(lane->method));
  seat.panel.change_facts([&](DeviceFacts& facts) {
    facts.method = method;
    facts.tradeoff = lane->worth;
  });
  // One that the estimate thread never came to take is retired by nobody else.
  if (Lane* untaken = seat.incoming.exchange(lane, std::memory_order_acq_rel)) untaken->retired = true;
  log_.write(LogLevel::info, {seat.panel.name}, "%s: estimating by %s%s", seat.panel.name.c_str(),
             method.c_str(), past);
  return *lane;
}

// By a sensor of the same name, in every way configured as it was.
std::optional<EstimatorChain> LaneMaker::inherited(const Seat& seat, const ChainSetup& setup) {
  const auto found = std::find_if(inherited_.begin(), inherited_.end(), [&](const Learnt& learnt) {
    return learnt.sensor == seat.settings && learnt.setup == setup;
  });
  if (found == inherited_.end()) return std::nullopt;
  EstimatorChain chain = std::move(found->chain);
  inherited_.erase(found);
  return chain;
}

// The last lane of each sensor is the one that was in use.
std::vector<Learnt> LaneMaker::give_up() {
  std::vector<Learnt> learnt;
  for (std::size_t sensor = 0; sensor < seats_.size(); ++sensor) {
    const auto last = std::find_if(lanes_.rbegin(), lanes_.rend(),
                                   [&](const auto& lane) { return lane->sensor == sensor; });
    if (last == lanes_.rend()) continue;
    learnt.push_back({seats_[sensor]->settings, (*last)->setup, std::move((*last)->chain)});
  }
  lanes_.clear();
  // And what was kept for a device that never came.
  std::move(inherited_.begin(), inherited_.end(), std::back_inserter(learnt));
  return learnt;
}

void LaneMaker::free_retired() {
  // Acquire: pairs with the estimate thread's release, so that its last use is over.
  std::erase_if(lanes_, [](const auto& lane) { return lane->retired.load(std::memory_order_acquire); });
}

}  // namespace slipd
