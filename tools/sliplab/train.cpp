// sliplab train: trains the model of a scene and stores it where slipd looks for it. slipd starts it as a
// child process when no model exists, so that training takes neither time nor memory of the process that
// estimates.
#include "paper/train.hpp"

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>

#include "config/settings.hpp"
#include "paper/model/model_file.hpp"
#include "paper/model/setup_json.hpp"
#include "paper/model_setup.hpp"
#include "paper/validation/tradeoff.hpp"
#include "tools/offline/progress.hpp"
#include "tools/sliplab/command.hpp"

namespace sliplab {
namespace {

using nlohmann::json;
using namespace slipd;

struct Choices {
  std::string config, sensor, setup;
  std::string model;  // the file for the model
  unsigned threads = 2;
  bool anew = false;
};

// Training uses no driver: any name and any options are valid.
class AnyDriver final : public DriverCatalogue {
 public:
  const DriverModule* find(const std::string&) override { return &any_; }
  std::string why_not(const std::string&) override { return {}; }
  std::vector<std::string> names() override { return {}; }

 private:
  DriverModule any_{kDriverAbi, "any", "", R"({"type": "object"})", nullptr};
};

ModelSetup setup_from_config(const std::string& file, const std::string& name) {
  AnyDriver drivers;
  const Settings settings = load_settings(file, drivers);
  std::string known;
  for (const auto& sensor : settings.sensors) {
    if (sensor.setup.name == name) {
      return model_setup_of({.layout = sensor.setup.layout,
                             .sensor_class = SensorClass::array3,
                             .scene = settings.scene_of(sensor),
                             .estimator = settings.estimator,
                             .alerts = settings.alerts,
                             .friction = sensor.friction});
    }
    known += (known.empty() ? "" : ", ") + sensor.setup.name;
  }
  throw offline::WrongUse(file + ": has no sensor " + name + "; it has " + known);
}

ModelSetup setup_from_json(const std::string& file) {
  std::ifstream stream;
  if (file != "-") {
    stream.open(file);
    if (!stream) throw offline::WrongUse(file + ": cannot be read");
  }
  std::istream& from = file == "-" ? std::cin : stream;
  const std::string text{std::istreambuf_iterator<char>(from), {}};
  try {
    return setup_of(json::parse(text));
  } catch (const std::exception& error) {
    throw offline::WrongUse(file + ": is no model setup: " + error.what());
  }
}

json report(const Model& model, const std::filesystem::path& file, double seconds) {
  json explained = json::array();
  for (std::size_t i = 1; i <= model.rank(); ++i) explained.push_back(model.explained(i));
  json rows = json::array();
  for (const auto& row : model.data().work_precision.rows) {
    rows.push_back({{"method", row.method},
                    {"rank", row.settings.rank},
                    {"rings", row.settings.rings},
                    {"precision", to_string(row.settings.precision)},
                    {"mean_error", row.mean_error},
                    {"answered", row.answered},
                    {"p50_us", row.p50_us}});
  }
  return {{"file", file.string()},
          {"seconds", seconds},
          {"taxels", model.setup().layout.size()},
          {"columns", model.setup().size.columns()},
          {"explained", explained},
          {"error_68", model.data().errors.gamma},
          {"tradeoff", std::move(rows)}};
}

void print(const json& result) {
  std::cout << result["file"].get<std::string>() << "\n"
            << result["columns"] << " columns of " << result["taxels"] << " taxels; "
            << result["explained"].size() << " bases explain "
            << std::round(1000 * result["explained"].back().get<double>()) / 10 << " % of the variance\n";
}

// The ring counts with which a model on rings is compared.
std::vector<int> other_rings(const ModelSetup& setup) {
  std::vector<int> others;
  for (const int rings : {4, 8, 16}) {
    if (setup.view == View::rings && rings != setup.rings && rings >= setup.rank) others.push_back(rings);
  }
  return others;
}

// The model with the work-precision of each method and setting on its scene.
ModelData trained(const ModelSetup& setup, unsigned threads, const Progress& progress) {
  constexpr std::size_t kContacts = 300;
  std::vector<int> ranks{setup.rank};
  for (const int rank : {3, 5, 8}) {
    if (rank < setup.rank) ranks.push_back(rank);
  }
  const std::vector<int> others = other_rings(setup);
  const double parts = 1 + static_cast<double>(others.size());
  double done = 0;
  const Progress part = [&](double share, const char* what) { progress((done + share) / parts, what); };
  std::vector<ModelData> at_ranks = train_ranks(setup, ranks, threads, part);
  std::vector<std::shared_ptr<const Model>> models;
  models.reserve(at_ranks.size() + others.size());
  for (const auto& data : at_ranks) models.push_back(std::make_shared<const Model>(data));
  for (const int rings : others) {
    ++done;
    ModelSetup other = setup;
    other.rings = rings;
    models.push_back(std::make_shared<const Model>(train(other, threads, part)));
  }
  at_ranks.front().work_precision = measure_work_precision(models, kContacts, setup.seed + 1);
  return std::move(at_ranks.front());
}

// Writes the model to a descriptor for slipd, which stores it.
void write_to_output(const ModelData& data) {
  const std::vector<std::uint8_t> bytes = encode_model(data);
  std::cout.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!std::cout.flush()) throw std::runtime_error("the model cannot be written to the standard output");
}

void run(const Choices& choices, const offline::Common& common) {
  const ModelSetup setup = choices.setup.empty() ? setup_from_config(choices.config, choices.sensor)
                                                 : setup_from_json(choices.setup);
  if (choices.model == "-")
    return write_to_output(trained(setup, choices.threads, offline::ProgressBar("training").callback()));
  const std::filesystem::path file = choices.model.empty() ? model_cache_file(setup, model_cache_directory())
                                                           : std::filesystem::path(choices.model);
  const auto started = std::chrono::steady_clock::now();
  const auto tell = [&](const Model& model) {
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - started;
    const json result = report(model, file, taken.count());
    common.json ? void(std::cout << result << '\n') : print(result);
  };
  if (!choices.anew && std::filesystem::exists(file)) {
    try {
      const Model kept = load_model(file);
      if (kept.setup() == setup) return tell(kept);
      std::cerr << "sliplab: " << file.string() << ": is a model of another scene: it is made anew\n";
    } catch (const ModelError& error) {
      std::cerr << "sliplab: " << error.what() << ": it is made anew\n";
    }
  }
  offline::ProgressBar bar("training");
  save_model(trained(setup, choices.threads, bar.callback()), file);
  tell(load_model(file));
}

}  // namespace

void add_train(CLI::App& app, const offline::Common& common) {
  auto choices = std::make_shared<Choices>();
  CLI::App* command = app.add_subcommand("train", "train the model of a sensor for svd-knn or registered");
  auto* config = command->add_option("--config", choices->config, "a configuration of slipd");
  auto* sensor = command->add_option("--sensor", choices->sensor, "name of a sensor in the configuration")
                     ->needs(config);
  config->needs(sensor);
  command
      ->add_option("--setup", choices->setup,
                   "instead of --config: the setup to train for, a file of JSON; - for standard input")
      ->excludes(config);
  command->add_option("--model", choices->model,
                      "the file to write, - for standard output; default: where slipd looks for it");
  command->add_option("--threads", choices->threads, "threads to compute with")
      ->check(CLI::Range(1, 4))
      ->capture_default_str();
  command->add_flag("--anew", choices->anew, "train even if a valid model exists");
  command->callback([choices, &common] {
    if (choices->config.empty() && choices->setup.empty()) {
      throw CLI::RequiredError("--config with --sensor, or --setup,");
    }
    run(*choices, common);
  });
}

}  // namespace sliplab
