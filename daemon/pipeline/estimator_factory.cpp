#include "daemon/pipeline/estimator_factory.hpp"

#include <algorithm>
#include <iterator>
#include <new>
#include <utility>

#include "core/chain/setup/method_table.hpp"
#include "core/frame/few_taxels.hpp"

namespace slipd {
namespace {

constexpr std::size_t kFactoryStackBytes = std::size_t{1024} * 1024;

}  // namespace

std::string why_method_is_replaced(const ChainSetup& setup) {
  const MethodChoice configured = setup.estimator.method;
  if (!fits_whole_pad(setup) || configured == MethodChoice::automatic || configured == MethodChoice::fit)
    return {};
  return "fit is used and not the configured estimator.method: while tracking is on, a sensor of at most " +
         std::to_string(kFewTaxels) + " taxels always uses fit, as no single frame tells its margin";
}

EstimatorFactory::EstimatorFactory(const Settings& settings,
                                   std::vector<std::unique_ptr<SensorRuntime>>& runtimes, LogRing& log,
                                   EstimateThreads& estimate, ModelSource models)
    : settings_(settings), runtimes_(runtimes), log_(log), estimate_(estimate), models_(std::move(models)) {}

EstimatorFactory::~EstimatorFactory() = default;

void EstimatorFactory::start() {
  thread_ = Thread("set-up", kFactoryStackBytes, [this] { run(); });
}

void EstimatorFactory::request_stop() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_one();
}

void EstimatorFactory::request(std::size_t sensor, std::shared_ptr<FrameFeed> feed) {
  {
    const std::lock_guard lock(mutex_);
    jobs_.push_back({sensor, std::move(feed)});
  }
  changed_.notify_one();
}

void EstimatorFactory::run() {
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
    } catch (const std::bad_alloc&) {  // no memory even for the message
      runtimes_[job.sensor]->refused.store(true, std::memory_order_relaxed);
      estimate_.of(job.sensor).ring();
    }
  }
}

void EstimatorFactory::make(const Job& job) {
  SensorRuntime& runtime = *runtimes_[job.sensor];
  try {
    build(job, runtime);
    runtime.refused.store(false, std::memory_order_relaxed);
  } catch (const std::exception& error) {
    const std::string trouble = error.what();
    runtime.status.change_facts([&](DeviceFacts& facts) { facts.trouble = trouble; });
    runtime.refused.store(true, std::memory_order_relaxed);
    log_.write(LogLevel::error, {runtime.status.name, Cause::configuration}, "%s: no estimator: %s",
               runtime.status.name.c_str(), trouble.c_str());
  }
  estimate_.of(job.sensor).ring();
}

const EstimatorInstance& EstimatorFactory::build(const Job& job, SensorRuntime& runtime) {
  const ChainSetup setup{.layout = job.feed->info.layout,
                         .sensor_class = job.feed->info.sensor_class,
                         .scene = settings_.scene_of(runtime.settings, job.feed->info.skin),
                         .estimator = settings_.estimator,
                         .alerts = settings_.alerts,
                         .friction = runtime.settings.friction,
                         .full_scale = runtime.settings.full_scale,
                         .contact = runtime.settings.contact};
  std::optional<EstimatorChain> chain = take_learned_state(runtime, setup);
  const char* const past = chain ? ", with what it had learnt before the reload" : "";
  if (!chain) {
    std::shared_ptr<const TrainedModel> model;
    if (needs_model(setup)) model = models_(runtime.status.name, setup);
    chain.emplace(setup, model);
    if (const std::string why = why_method_is_replaced(setup); !why.empty())
      log_.write(LogLevel::warning, {runtime.status.name, Cause::configuration}, "%s: %s",
                 runtime.status.name.c_str(), why.c_str());
  }
  instances_.push_back(std::make_unique<EstimatorInstance>(job.sensor, job.feed, setup, std::move(*chain)));
  EstimatorInstance* const instance = instances_.back().get();
  const std::string method(to_string(instance->method));
  runtime.status.change_facts([&](DeviceFacts& facts) {
    facts.method = method;
    facts.method_reason = to_string(why_method(setup));
    facts.tradeoff = instance->work_precision;
    facts.budget_us = frame_budget_us(setup);
  });
  // An instance that the estimate thread did not take is retired here.
  if (EstimatorInstance* untaken = runtime.incoming.exchange(instance, std::memory_order_acq_rel))
    untaken->retired = true;
  log_.write(LogLevel::info, {runtime.status.name}, "%s: estimating by %s%s", runtime.status.name.c_str(),
             method.c_str(), past);
  return *instance;
}

// The learned state of a sensor with the same settings and set-up; none otherwise.
std::optional<EstimatorChain> EstimatorFactory::take_learned_state(const SensorRuntime& runtime,
                                                                   const ChainSetup& setup) {
  const auto found = std::find_if(learned_.begin(), learned_.end(), [&](const LearnedState& learned) {
    return learned.sensor == runtime.settings && learned.setup == setup;
  });
  if (found == learned_.end()) return std::nullopt;
  EstimatorChain chain = std::move(found->chain);
  learned_.erase(found);
  return chain;
}

// The last instance of each sensor is the one that was in use.
std::vector<LearnedState> EstimatorFactory::release_learned_state() {
  std::vector<LearnedState> learned;
  for (std::size_t sensor = 0; sensor < runtimes_.size(); ++sensor) {
    const auto last = std::find_if(instances_.rbegin(), instances_.rend(),
                                   [&](const auto& instance) { return instance->sensor == sensor; });
    if (last == instances_.rend()) continue;
    learned.push_back({runtimes_[sensor]->settings, (*last)->setup, std::move((*last)->chain)});
  }
  instances_.clear();
  // Unused ones too: their devices may be opened later.
  std::move(learned_.begin(), learned_.end(), std::back_inserter(learned));
  return learned;
}

void EstimatorFactory::free_retired() {
  // Acquire: pairs with the release in EstimateLoop::adopt_instance, so that its last use has ended.
  std::erase_if(instances_,
                [](const auto& instance) { return instance->retired.load(std::memory_order_acquire); });
}

}  // namespace slipd
