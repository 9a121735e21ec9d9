// slipctl: queries a running slipd, and inspects devices without one. Exit 0 success, 1 failure, 2 wrong
// usage.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <string>
#include <vector>

#include "schema/schema.hpp"
#include "tools/slipctl/calibrate.hpp"
#include "tools/slipctl/client.hpp"
#include "tools/slipctl/commands.hpp"
#include "tools/slipctl/decode.hpp"
#include "tools/slipctl/export.hpp"
#include "tools/slipctl/fleet.hpp"
#include "tools/slipctl/import.hpp"
#include "tools/slipctl/plot.hpp"
#include "tools/slipctl/probe.hpp"
#include "tools/slipctl/watch.hpp"

namespace {

using namespace slipctl;

struct Choices {
  CommonOptions common{kDefaultSocket, false};
  std::string sensor;
  std::string name;  // of a sensor or grasp
  RecordOptions record;
  WatchOptions watch;
  CalibrateOptions calibrate;
  bool force = false;
  double releasing_s = 2;
  DecodeOptions decode;
  PlotOptions plot;
  ExportOptions exporting;
  ImportOptions importing;
  FleetOptions fleet;
  int exit_code = 0;
};

void add_questions(CLI::App& app, Choices& choices) {
  app.add_subcommand("status", "the daemon's state: counts, rates, latency, real time, clients")
      ->callback([&] { print_status(choices.common); });
  app.add_subcommand("metrics", "counters, rates and latencies as OpenMetrics text")->callback([&] {
    print_metrics(choices.common);
  });
  app.add_subcommand("dbc", "the CAN messages of the running configuration as a DBC file")->callback([&] {
    print_dbc(choices.common);
  });
  app.add_subcommand("sensors", "the sensors and what each is")->callback([&] {
    print_sensors(choices.common);
  });
  CLI::App* gamma = app.add_subcommand("gamma", "the latest safety margin of each sensor and grasp");
  gamma->add_option("name", choices.name, "only this sensor or grasp");
  gamma->callback([&] { print_gamma(choices.common, choices.name); });
  CLI::App* frame = app.add_subcommand("frame", "the latest frame, one taxel a line (CSV)");
  frame->add_option("sensor", choices.sensor)->required();
  frame->callback([&] { print_frame(choices.common, choices.sensor); });
  CLI::App* flight = app.add_subcommand(
      "flight", "write the flight recorder's last seconds to a recording, and wait for it");
  flight->add_option("sensor", choices.sensor, "only this sensor");
  flight->callback([&] { choices.exit_code = keep_flight(choices.common, choices.sensor); });
  CLI::App* zero = app.add_subcommand("rebias", "take the unloaded sensor's values as its zero");
  zero->add_option("sensor", choices.sensor)->required();
  zero->add_flag("--force", choices.force, "even if it seems to be in contact");
  zero->callback([&] { rebias(choices.common, choices.sensor, choices.force); });
  CLI::App* release = app.add_subcommand(
      "releasing", "the robot lets go: no alert of slip from sensors that see displacements");
  release->add_option("sensor", choices.sensor, "only this sensor");
  release->add_option("--seconds", choices.releasing_s, "how long from now, s; 0: no longer")
      ->check(CLI::Range(0.0, 60.0))
      ->capture_default_str();
  release->callback([&] { releasing(choices.common, choices.sensor, choices.releasing_s); });
}

void add_record(CLI::App& app, Choices& choices) {
  CLI::App* command = app.add_subcommand("record", "record a sensor's frames into a file");
  command->add_option("--sensor", choices.record.sensor, "the sensor's name")->required();
  command->add_option("--seconds", choices.record.seconds, "length of the recording, s")
      ->check(CLI::Range(0.001, 86400.0))
      ->required();
  command->add_option("--out", choices.record.out, "the file, which must not exist yet")->required();
  command->add_flag("--force", choices.record.force, "overwrite an existing file");
  command->callback([&] { record(choices.common, choices.record); });
}

void add_calibrate(CLI::App& app, Choices& choices) {
  CalibrateOptions& calibrating = choices.calibrate;
  CLI::App* command =
      app.add_subcommand("calibrate", "find a sensor's scales, signs and axes with known weights");
  const auto weight = [&](const char* option, double& force_n, const char* help) {
    return command->add_option_function<std::string>(
        option,
        [option, &force_n](const std::string& text) {
          try {
            force_n = force_of(text);
          } catch (const std::invalid_argument& wrong) {
            throw CLI::ValidationError(option, wrong.what());
          }
        },
        help);
  };
  command->add_option("sensor", calibrating.sensor)->required();
  weight("--normal", calibrating.normal_n, "the weight that rests on the sensor, such as 200g")->required();
  weight("--shear", calibrating.shear_n, "the weight that pulls along +x and +y; default: none does");
  command->add_option("--seconds", calibrating.seconds, "of stillness that are read in each step")
      ->check(CLI::Range(0.1, 600.0))
      ->capture_default_str();
  command->add_flag("--corner", calibrating.corner,
                    "put the weight on two corners, too, to check the layout");
  CLI::Option* step =
      command->add_option("--step", calibrating.step, "only this step, without questions")
          ->check(CLI::IsMember({"zero", "normal", "shear-x", "shear-y", "corner", "corner-x"}));
  CLI::Option* file = command->add_option("--file", calibrating.file, "keeps what the steps have read");
  step->needs(file);
  file->needs(step);
  command->callback([&] { calibrate(choices.common, calibrating); });
}

void add_plot(CLI::App& app, Choices& choices) {
  CLI::App* command = app.add_subcommand("plot", "draw a recording: margin, alerts, forces and taxels");
  command->add_option("file", choices.plot.file)->required();
  command->add_option(
      "--at", choices.plot.at_s,
      "show the frame so many seconds after the begin; default: the frame of least margin, without "
      "estimates that of greatest normal force");
  command->add_option("--columns", choices.plot.columns, "width in characters; default: the terminal's")
      ->check(CLI::Range(40, 1000));
  command->add_option("--picture", choices.plot.picture, "write the screen to this file as SVG, too");
  command->callback([&] {
    choices.plot.json = choices.common.json;
    plot(choices.plot);
  });
}

void add_export(CLI::App& app, Choices& choices) {
  ExportOptions& exporting = choices.exporting;
  exporting.prefix = "/slipd";
  CLI::App* command = app.add_subcommand("export", "write a recording as MCAP of ROS 2 messages, or as CSV");
  command->add_option("file", exporting.file)->required();
  CLI::Option* mcap = command->add_option("--mcap", exporting.mcap, "the MCAP file to write");
  CLI::Option* csv = command->add_option("--csv", exporting.csv, "the CSV file to write");
  command->add_option("--prefix", exporting.prefix, "what the topics of the MCAP file begin with")
      ->capture_default_str();
  command->add_flag("--force", exporting.force, "replace files that exist");
  command->callback([&exporting, &choices, mcap, csv] {
    if (mcap->empty() && csv->empty()) throw CLI::RequiredError("--mcap or --csv");
    choices.exit_code = export_recording(exporting) ? 0 : 1;
  });
}

void add_import(CLI::App& app, Choices& choices) {
  ImportOptions& importing = choices.importing;
  importing.sensor = "sensor";
  CLI::App* command =
      app.add_subcommand("import", "write a recording of a ROS 2 topic of an MCAP file, such as of rosbag2");
  command->add_option("file", importing.file, "the MCAP file")->required();
  command->add_option("out", importing.out, "the recording to write")->required();
  command->add_option("--profile", importing.profile, "what the messages are: a profile of slipd-feed-ros2")
      ->required();
  command->add_option("--topic", importing.topic, "its name; if absent, as the profile says");
  command->add_option("--frame-id", importing.frame_id, "only messages with this frame_id");
  command->add_option("--sensor", importing.sensor, "the sensor's name in the recording")
      ->capture_default_str();
  command->add_option("--grid", importing.grid, "the sensor's layout: COLUMNSxROWS; 1x1 for a force");
  command->add_option("--pitch-mm", importing.pitch_mm, "of the grid");
  command->add_option("--taxels-mm", importing.taxels_mm, "the sensor's layout: places such as \"0,0 -6,0\"");
  command->add_option("--scale", importing.scale, "factors of x, y and z, such as 1,1,-1")->delimiter(',');
  command->add_flag("--force", importing.force, "replace a file that exists");
  command->callback([&importing, &choices] { choices.exit_code = import_recording(importing) ? 0 : 1; });
}

void add_watch(CLI::App& app, Choices& choices) {
  WatchOptions& watching = choices.watch;
  CLI::App* command =
      app.add_subcommand("watch", "follow the margins: a live view on a terminal, lines elsewhere");
  command->add_option("names", watching.names, "only these sensors, and those of these grasps");
  command->add_option("--seconds", watching.seconds, "end after so many seconds")->check(CLI::PositiveNumber);
  command
      ->add_option("--rate", watching.lines_per_s,
                   "lines per second and sensor, where stdout is not a terminal; default: 5")
      ->check(CLI::Range(0.1, 100000.0));
  command
      ->add_option("--grip", watching.grip,
                   "slipd-grip's socket for orders; what it does is shown where it runs")
      ->capture_default_str();
  command->add_flag("--plain", watching.plain, "lines even on a terminal");
  command->add_flag("--summary", watching.summary, "print statistics of every estimate at the end");
  command->add_flag("--expect-slip", watching.expect_slip, "exit with 1 if no slip was seen");
  command->add_option("--picture", watching.picture, "write the last screen to this file as SVG");
  command->callback([&] {
    watching.socket = choices.common.socket;
    watching.json = choices.common.json;
    choices.exit_code = watch(watching);
  });
}

void add_fleet(CLI::App& app, Choices& choices) {
  CLI::App* command = app.add_subcommand(
      "fleet", "the grippers of an MQTT broker, a line each: a live view on a terminal, lines elsewhere");
  // An option of slipd-fleet, which checks its value.
  const auto pass = [&](const char* option, const char* help) {
    command->add_option_function<std::string>(
        option,
        [&choices, option](const std::string& value) {
          choices.fleet.arguments.insert(choices.fleet.arguments.end(), {option, value});
        },
        help);
  };
  pass("--broker", "HOST[:PORT]; default: localhost");
  pass("--prefix", "what the topics begin with; default: slipd");
  pass("--user", "user name at the broker");
  pass("--password-file", "file with the password in its first line");
  pass("--ca-file", "TLS: trusted authorities, PEM");
  pass("--cert-file", "TLS: own certificate, PEM");
  pass("--key-file", "TLS: its key, PEM");
  command->add_flag_callback(
      "--tls", [&] { choices.fleet.arguments.emplace_back("--tls"); }, "TLS with the system's authorities");
  command->add_flag("--once", choices.fleet.once, "print the present lines and end");
  command->callback([&] {
    choices.fleet.json = choices.common.json;
    choices.exit_code = fleet(choices.fleet);
  });
}

void add_devices(CLI::App& app, Choices& choices) {
  app.add_subcommand("probe", "the devices present, and the profiles that match them")->callback([&] {
    print_probe(choices.common.json, std::cout);
  });
  CLI::App* command = app.add_subcommand(
      "decode", "decode a capture on standard input: `candump -L` of CAN, else the device's bytes");
  command->add_option("profile", choices.decode.profile)->required();
  command->add_option("--board", choices.decode.board, "the board's number on a CAN bus")
      ->capture_default_str();
  command->callback([&] {
    choices.decode.json = choices.common.json;
    choices.exit_code = decode(choices.decode, std::cin, std::cout, std::cerr) ? 0 : 1;
  });
}

std::vector<std::string> names_of_commands(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(command->get_name());
  return names;
}

std::string commands_are(const std::vector<std::string>& names) {
  std::string text = "commands are ";
  for (std::size_t i = 0; i < names.size(); ++i) text += (i == 0 ? "" : ", ") + names[i];
  return text;
}

int wrong_usage(const std::string& what) {
  std::fprintf(stderr, "slipctl: %s\n", what.c_str());
  return 2;
}

}  // namespace

int main(int argc, char** argv) try {
  Choices choices;
  CLI::App app{"Asks a running slipd how far each grasp is from slipping, and inspects devices.", "slipctl"};
  app.set_version_flag("--version", "slipctl " SLIPD_VERSION);
  app.add_option("--socket", choices.common.socket, "the daemon's socket")->capture_default_str();
  app.add_flag("--json", choices.common.json, "the daemon's own answers, one JSON object a line");
  app.fallthrough();
  app.require_subcommand(0, 1);
  add_questions(app, choices);
  add_record(app, choices);
  add_calibrate(app, choices);
  add_plot(app, choices);
  add_export(app, choices);
  add_import(app, choices);
  add_watch(app, choices);
  add_fleet(app, choices);
  add_devices(app, choices);
  try {
    app.parse(argc, argv);
    if (app.get_subcommands().empty())
      return wrong_usage("no command; " + commands_are(names_of_commands(app)));
  } catch (const CLI::ExtrasError& wrong) {
    const std::vector<std::string> words = app.remaining();
    if (!app.get_subcommands().empty() || words.empty() || words.front().starts_with('-'))
      return app.exit(wrong) == 0 ? 0 : 2;
    const std::vector<std::string> names = names_of_commands(app);
    return wrong_usage("no such command: " + words.front() + slipd::did_you_mean(words.front(), names) +
                       "; " + commands_are(names));
  } catch (const CLI::ParseError& wrong) {
    return app.exit(wrong) == 0 ? 0 : 2;
  }
  return choices.exit_code;
} catch (const std::exception& failed) {
  std::fflush(stdout);
  std::fprintf(stderr, "slipctl: %s\n", failed.what());
  return 1;
}
