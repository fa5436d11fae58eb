#include "tools/sft/command_line.h"

#include <sft/options.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <iostream>
#include <iterator>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <system_error>

#include "tools/sft/help_format.h"

namespace sft::tool {

namespace {

/// The options of all subcommands. CLI11 writes to the options of the chosen subcommand.
struct Parsed {
  CommandLine line;
  LsOptions ls;
  InfoOptions info;
  TypeOptions type;
  EchoOptions echo;
  PubOptions pub;
  HzOptions hz;
  BwOptions bw;
  DelayOptions delay;
  WhyOptions why;
  TopOptions top;
  DoctorOptions doctor;
  RecordOptions record{.version = SFT_VERSION};
  PlayOptions play;
  BagOptions bag;
  BridgeOptions bridge;
  PerfOptions perf;
  std::vector<std::string> beside;
  std::string host;
  struct {
    bool csv = false, yaml = false;
  } forms{};  ///< the forms of samples, for echo
};

NodeOptions::VanillaDds dds_choice(const std::string& name) {
  using enum NodeOptions::VanillaDds;
  return name == "auto" ? automatic : name == "never" ? never : always;
}

CLI::App* declare(CLI::App& app, Parsed& parsed, const char* name, const char* help) {
  CommonOptions& common = parsed.line.common;
  CLI::App* command = app.add_subcommand(name, help);
  command->add_flag("--json", common.json, "Write JSON, for programs")->group("Common");
  command
      ->add_flag("--no-color", common.no_color,
                 "Use no colours on terminals; the environment variable NO_COLOR does the same")
      ->group("Common");
  command->add_option("--domain", common.domain, "The domain to look at (default: $ROS_DOMAIN_ID, or 0)")
      ->check(CLI::Range(0, static_cast<int>(NodeOptions::domain_max)))
      ->group("Common");
  command
      ->add_option("--interface", common.interfaces,
                   "Look for nodes on this interface only: a name, an address or a network")
      ->allow_extra_args(false)
      ->group("Common");
  command
      ->add_option("--peer", common.peers,
                   "Look for nodes on this host, too; they have to name this host as a peer as well")
      ->allow_extra_args(false)
      ->group("Common");
  command
      ->add_option_function<std::string>(
          "--dds", [&common](const std::string& choice) { common.dds = dds_choice(choice); },
          "Look for nodes of DDS and ROS 2 that know nothing of SFT (default: always); auto: as programs do")
      ->envname("SFT_VANILLA_DDS")
      ->check(CLI::IsMember({"auto", "always", "never"}))
      ->group("Common");
  command
      ->add_option(
          "--wait", common.wait_s,
          "Collect for this many seconds before printing what is there; 'why' then waits as long again "
          "for nodes that have not reported their counters")
      ->check(CLI::Range(0.0, 3600.0))
      ->capture_default_str()
      ->group("Common");
  command
      ->add_option("--timeout", common.timeout_s,
                   "Wait at most this many seconds for the topic, or for its first sample")
      ->check(CLI::Range(0.0, 86400.0))
      ->capture_default_str()
      ->group("Common");
  command->footer(exit_codes_help);
  return command;
}

constexpr const char* one_topic = "The topic, with or without a leading slash";

/// Declares a subcommand with one topic.
template <class Options>
CLI::App* declare(CLI::App& app, Parsed& parsed, const char* name, Options Parsed::*options,
                  const char* help) {
  CLI::App* command = declare(app, parsed, name, help);
  command->add_option("TOPIC", (parsed.*options).topic, one_topic)->required();
  command->callback([&parsed, options] { parsed.line.command = parsed.*options; });
  return command;
}

/// Adds --count, and --once, which has the effect of --count 1.
void add_count(CLI::App* command, std::uint64_t& count, const char* of_one, const char* of_many) {
  const auto one = [&count](std::int64_t) { count = 1; };
  CLI::Option* once = command->add_flag_function("--once", one, of_one);
  command->add_option("-n,--count", count, of_many)->check(CLI::PositiveNumber)->excludes(once);
}

void add_live(CLI::App* command, LiveOptions& live) {
  command->add_option("--for", live.for_s, "End after this many seconds (default: when Ctrl-C is pressed)")
      ->check(CLI::Range(0.1, 1e9));
  command->add_option("--window", live.window_s, "Measure over a window of this many seconds")
      ->check(CLI::Range(1.0, 3600.0))
      ->capture_default_str();
}

/// Adds the option for directories with definitions of types, which a command needs if nodes do not
/// announce the fields of a type.
void add_includes(CLI::App* command, CommonOptions& common) {
  command
      ->add_option("-I,--include", common.includes,
                   "Search this directory for packages with .msg files: /opt/ros/humble/share")
      ->allow_extra_args(false);
}

void declare_ls(CLI::App& app, Parsed& parsed) {
  CLI::App* command = declare(app, parsed, "ls", "List nodes, topics, types or endpoints");
  command->add_option("WHAT", parsed.ls.what, "List these: nodes, topics (the default), types or endpoints")
      ->check(CLI::IsMember({"nodes", "topics", "types", "endpoints"}));
  command->add_flag("--names", parsed.ls.names, "Print the names only, one per line");
  command->callback([&parsed] { parsed.line.command = parsed.ls; });
}

void declare_info(CLI::App& app, Parsed& parsed) {
  declare(app, parsed, "info", &Parsed::info, "Show the publishers and subscribers of a topic");
}

void declare_type(CLI::App& app, Parsed& parsed) {
  CLI::App* command =
      declare(app, parsed, "type", &Parsed::type,
              "Print the message type of a topic, or one by its name, as the text of .msg files");
  command->get_option("TOPIC")->description(
      "The topic, with or without a leading slash; or the name of a type: sensor_msgs/PointCloud2");
  command->add_flag("--name", parsed.type.name, "Print its name only");
  command->add_flag("--fields", parsed.type.fields, "Print its fields only, one per line");
  add_includes(command, parsed.line.common);
}

void declare_echo(CLI::App& app, Parsed& parsed) {
  EchoOptions& echo = parsed.echo;
  CLI::App* command =
      declare(app, parsed, "echo", &Parsed::echo, "Print the samples of a topic, or some of their fields");
  command
      ->add_option("--fields", echo.fields,
                   "Ask publishers for these fields only: 'header.stamp, fields[].name'; * is all. "
                   "Of a field this can be a part, for example 'data{x,y,z}', 'ranges[::4]'. "
                   "Behind @ stands when a sample is needed: 'voltage @ changed 1% or every 10 s'. "
                   "The option may be given several times: then samples come by each of these selections")
      ->allow_extra_args(false)
      ->default_str("*");
  add_count(command, echo.count, "End after one sample", "End after this many samples");
  command
      ->add_option("--rate", echo.max_rate_hz, "Ask for at most this many samples a second of each selection")
      ->check(CLI::Range(SubscriberOptions::slowest_rate_hz, SubscriberOptions::fastest_rate_hz));
  CLI::Option* yaml = command->add_flag("--yaml", parsed.forms.yaml, "Write YAML (the default)");
  CLI::Option* csv =
      command->add_flag("--csv", parsed.forms.csv, "Write a table, with a column for each field");
  command->get_option("--json")->excludes(yaml)->excludes(csv);
  csv->excludes(yaml);
  add_includes(command, parsed.line.common);
  command->add_flag("--full", echo.full, "Do not shorten long arrays and texts on terminals");
  command->callback([&parsed] {
    parsed.echo.format = parsed.line.common.json ? Format::json
                         : parsed.forms.csv      ? Format::csv
                                                 : Format::yaml;
    parsed.line.command = parsed.echo;
  });
}

void declare_pub(CLI::App& app, Parsed& parsed) {
  PubOptions& pub = parsed.pub;
  CLI::App* command =
      declare(app, parsed, "pub", &Parsed::pub, "Publish a message that is written as YAML or JSON");
  command
      ->add_option("TYPE", pub.type,
                   "The type: sensor_msgs/PointCloud2, a file my_msgs/msg/Status.msg, or auto for the type "
                   "that the topic has")
      ->required();
  command->add_option(
      "VALUE", pub.value,
      "The message: '{header: auto, width: 3}'. Fields that you leave out are zero or empty, and a stamp "
      "may be now. With - the messages come from the standard input: YAML with --- between them, or one "
      "line of JSON each");
  command->add_option("-r,--rate", pub.rate_hz, "Publish this many samples a second (default: 1)")
      ->check(CLI::Range(SubscriberOptions::slowest_rate_hz, SubscriberOptions::fastest_rate_hz));
  add_count(command, pub.count, "Publish the message once", "Publish the message this many times");
  command->add_option(
      "-w,--wait-for", pub.wait_for,
      "First wait for this many subscribers, at most for --timeout (default: 1 if the command ends by "
      "itself, else 0)");
  command->add_flag("--reliable", pub.reliable, "Offer to send lost samples again");
  command->add_flag("--transient-local", pub.transient_local, "Keep the last sample for late subscribers");
  add_includes(command, parsed.line.common);
}

void declare_hz(CLI::App& app, Parsed& parsed) {
  CLI::App* command =
      declare(app, parsed, "hz", "Measure how often samples arrive, without asking for any field");
  command->add_option("TOPIC", parsed.hz.topics, "The topics, with or without a leading slash")->required();
  add_live(command, parsed.hz.live);
  add_includes(command, parsed.line.common);
  command->callback([&parsed] { parsed.line.command = parsed.hz; });
}

void declare_bw(CLI::App& app, Parsed& parsed) {
  CLI::App* command =
      declare(app, parsed, "bw", &Parsed::bw, "Measure how many bytes per second a topic has");
  command->add_option("--fields", parsed.bw.fields, "Measure these fields only; * is all")
      ->capture_default_str();
  command->add_flag("--every", parsed.bw.every,
                    "Ask for every sample, instead of one sample per second and the rate of all");
  add_live(command, parsed.bw.live);
  add_includes(command, parsed.line.common);
}

void declare_delay(CLI::App& app, Parsed& parsed) {
  CLI::App* command = declare(app, parsed, "delay", &Parsed::delay,
                              "Measure how old samples are when they arrive, by header.stamp");
  CLI::Option* published = command->add_flag("--published", parsed.delay.published,
                                             "Measure from the time of publication instead");
  command
      ->add_option("--field", parsed.delay.field,
                   "Measure by this field of the type Time instead: 'transforms[0].header.stamp'")
      ->excludes(published);
  add_live(command, parsed.delay.live);
  add_includes(command, parsed.line.common);
}

void declare_why(CLI::App& app, Parsed& parsed) {
  CLI::App* command = declare(
      app, parsed, "why", &Parsed::why,
      "Show whether publishers and subscribers of a topic match, by which path and why, and what was sent");
  command->add_flag("--types", parsed.why.types, "Print both definitions of a type if they differ");
}

void declare_top(CLI::App& app, Parsed& parsed) {
  CLI::App* command = declare(app, parsed, "top", "Show all topics and pairs live, until you press q");
  command
      ->add_option("--every", parsed.top.every_s, "Update the page each time this many seconds have passed")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  command->add_option("--for", parsed.top.for_s, "End after this many seconds")->check(CLI::Range(0.1, 1e9));
  command->callback([&parsed] { parsed.line.command = parsed.top; });
}

void declare_doctor(CLI::App& app, Parsed& parsed) {
  CLI::App* command =
      declare(app, parsed, "doctor", "Check whether this host is set up well, and say what to do");
  command->add_flag("--quiet", parsed.doctor.quiet, "Print warnings and errors only");
  command->callback([&parsed] { parsed.line.command = parsed.doctor; });
}

void declare_record(CLI::App& app, Parsed& parsed) {
  RecordOptions& record = parsed.record;
  CLI::App* command =
      declare(app, parsed, "record", "Write samples into a file (MCAP), until Ctrl-C is pressed");
  command->add_option("TOPICS", record.topics,
                      "Topics; behind each can stand which fields and parts, and when: 'imu', "
                      "'points{header.stamp, data{x,y,z}[::2]}@every 2', 'battery{voltage}@changed 1%'");
  command->add_flag("-a,--all", record.all, "Record all topics, also those that come later");
  command->add_option("-o,--output", record.output, "The file to write (default: a name with the time)");
  command->add_option("--compression", record.compression, "Compress the samples")
      ->check(CLI::IsMember({"none", "lz4", "zstd"}))
      ->capture_default_str();
  command->add_option("--split-mb", record.split_mb, "Begin a new file after this many megabytes")
      ->check(CLI::Range(0.1, 1e9));
  command->add_option("--split-time", record.split_s, "Begin a new file after this many seconds")
      ->check(CLI::Range(0.1, 1e9));
  command
      ->add_option("--last", record.last_s,
                   "Keep this many seconds in memory, and write them when a condition of --on holds")
      ->check(CLI::Range(0.1, 86400.0));
  command
      ->add_option("--on", record.on,
                   "With --last: write when this holds for a sample of any topic with such fields, "
                   "'level >= 2', or of one topic, 'diagnostics@level >= 2'")
      ->allow_extra_args(false);
  command->add_option("--memory-mb", record.memory_mb, "The most memory for samples that are not written yet")
      ->check(CLI::Range(1.0, 1e9))
      ->capture_default_str();
  command->add_option("--for", record.for_s, "End after this many seconds")->check(CLI::Range(0.1, 1e9));
  command->add_flag("--use-sim-time", parsed.line.common.sim_time,
                    "Record with the time of /clock, and nothing before its first sample");
  add_includes(command, parsed.line.common);
  command->callback([&parsed] { parsed.line.command = parsed.record; });
}

void declare_play(CLI::App& app, Parsed& parsed) {
  PlayOptions& play = parsed.play;
  CLI::App* command = declare(app, parsed, "play", "Publish the samples of recordings again");
  command->add_option("FILES", play.files, "Recordings: MCAP, SQLite files of rosbag2, or folders with them")
      ->required();
  command->add_option("--topics", play.topics, "Play these topics only");
  command->add_option("--remap", play.remap, "Play a topic under another name: OLD:=NEW")
      ->allow_extra_args(false);
  command->add_option("-r,--rate", play.rate, "Play so many times as fast")
      ->check(CLI::Range(0.001, 1000.0))
      ->capture_default_str();
  command->add_option("--start", play.start_s, "Begin so many seconds behind the first message")
      ->check(CLI::Range(0.0, 1e9));
  command->add_option("--for", play.for_s, "Play so many seconds of the recording")
      ->check(CLI::Range(0.001, 1e9));
  command->add_flag("-l,--loop", play.loop, "Begin anew at the end");
  command
      ->add_option("-w,--wait-for-subscribers", play.wait_for,
                   "Wait until each topic has as many subscribers, for at most --timeout seconds")
      ->expected(0, 1)
      ->default_str("1")
      ->check(CLI::NonNegativeNumber);
  command
      ->add_option("--clock", play.clock_hz,
                   "Publish the time of the recording on /clock, so many times a second")
      ->expected(0, 1)
      ->default_str("40")
      ->check(CLI::Range(0.1, 10000.0));
  add_includes(command, parsed.line.common);
  command->callback([&parsed] { parsed.line.command = parsed.play; });
}

void declare_bag(CLI::App& app, Parsed& parsed) {
  BagOptions& bag = parsed.bag;
  CLI::App* command = declare(app, parsed, "bag",
                              "Look at recordings, check them, or estimate what selections would have saved");
  command->add_option("WHAT", bag.what, "info, check, repair or estimate")
      ->required()
      ->check(CLI::IsMember({"info", "check", "repair", "estimate"}));
  command->add_option("FILES", bag.files, "Recordings: MCAP, SQLite files of rosbag2, or folders with them")
      ->required();
  command
      ->add_option(
          "--like", bag.like,
          "For estimate: a topic with the selection that a subscriber would have: 'points{data{x,y,z}}'")
      ->allow_extra_args(false);
  command->add_option("-o,--output", bag.output,
                      "For repair: write what can be read to this file, and check it");
  command->add_option("--html", bag.html, "For estimate: also write a page with bars to this file");
  add_includes(command, parsed.line.common);
  command->callback([&parsed] { parsed.line.command = parsed.bag; });
}

void declare_bridge(CLI::App& app, Parsed& parsed) {
  BridgeOptions& bridge = parsed.bridge;
  CommonOptions& common = parsed.line.common;
  CLI::App* command = declare(app, parsed, "bridge", "Carry topics from one domain to another, by rules");
  command->add_option("RULES", bridge.rules,
                      "What is carried, and under which name: 'points{data{x,y,z}}[::4] -> robot/points', "
                      "'cmd_vel <- robot/cmd_vel' from the second side, 'chatter <-> chatter' both ways, "
                      "'camera/* -> robot/camera/*@at most 5 Hz'");
  command->add_option("-f,--file", bridge.file, "Read both sides and rules from this file (TOML)");
  const auto dds = CLI::IsMember({"auto", "always", "never"});
  const auto domains = CLI::Range(0, static_cast<int>(NodeOptions::domain_max));
  command->add_option("--from", common.domain, "The domain of the first side; as --domain")->check(domains);
  command
      ->add_option("--from-dds", bridge.from_dds,
                   "When unmodified DDS nodes of the first side are heard and served")
      ->check(dds);
  command->add_option("--to", bridge.to, "The domain of the second side")->check(domains);
  command->add_option("--to-interface", bridge.to_interfaces, "As --interface, for the second side")
      ->allow_extra_args(false);
  command->add_option("--to-peer", bridge.to_peers, "As --peer, for the second side")
      ->allow_extra_args(false);
  command->add_option("--to-dds", bridge.to_dds, "As --from-dds, for the second side")->check(dds);
  command
      ->add_option("--defaults", bridge.each.defaults,
                   "These fields, which rules leave out, may be zero or empty on the other side; * is all")
      ->allow_extra_args(false);
  command
      ->add_option("--priority", bridge.priorities,
                   "TOPIC=NUMBER: of two large samples the one with the greater number is sent first")
      ->allow_extra_args(false);
  command->add_flag("--reliable", bridge.each.reliable,
                    "Send lost samples again, also if the publisher does not offer that");
  command->add_option("--for", bridge.for_s, "End after this many seconds")->check(CLI::Range(0.1, 1e9));
  add_includes(command, common);
  command->callback([&parsed] { parsed.line.command = parsed.bridge; });
}

void add_message(CLI::App* command, Parsed& parsed) {
  PerfOptions& perf = parsed.perf;
  CLI::Option* type =
      command->add_option("--type", perf.type, "Send messages of this type: sensor_msgs/PointCloud2");
  CLI::Option* value =
      command->add_option("--value", perf.value, "Send this message, as YAML or JSON")->needs(type);
  CLI::Option* size =
      command
          ->add_option(
              "--size", perf.size,
              "Send about so many bytes (default: 64); with --type, a PointCloud2 or a UInt8MultiArray")
          ->check(CLI::Range(1, 60 * 1024 * 1024))
          ->excludes(value);
  command->add_option("--like", perf.like, "Send a message like the next one of this topic")
      ->excludes(type)
      ->excludes(size);
  command->add_flag("--loan", perf.plan.loans,
                    "Send loans, which copy nothing within a host; for PointCloud2");
  add_includes(command, parsed.line.common);
}

/// Declares `sft perf ping` or `sft perf pub`.
void declare_sender(CLI::App& perf_command, Parsed& parsed, const char* name, bool answers,
                    const char* help) {
  perf::Plan& plan = parsed.perf.plan;
  CLI::App* command = declare(perf_command, parsed, name, help);
  command->add_option(
      "HOST", parsed.host,
      "The other machine, if multicast does not reach it; as --peer, which it then needs, too");
  add_message(command, parsed);
  command->add_option("--fields", plan.fields, "Ask for these fields only: 'header.stamp, data{x,y,z}[::2]'")
      ->default_str("*");
  const std::string usual = answers ? "100" : "0";
  command
      ->add_option("-r,--rate", plan.rate_hz,
                   "Send so many samples a second" + std::string(answers ? "" : "; 0: as fast as possible"))
      ->check(CLI::Range(answers ? 0.1 : 0, SubscriberOptions::fastest_rate_hz))
      ->default_str(usual);
  command->add_option("--for", plan.for_s, "Measure for so many seconds, each of --beside as long")
      ->check(CLI::Range(0.1, 1e6))
      ->capture_default_str();
  command->add_flag("--reliable", plan.reliable, "Send lost samples again");
  command->add_option("--transport", plan.transport, "Use only this path: shm or udp")
      ->transform(
          CLI::CheckedTransformer(std::map<std::string, TransportChoice>{{"auto", TransportChoice::automatic},
                                                                         {"shm", TransportChoice::shm},
                                                                         {"udp", TransportChoice::udp}}));
  command->add_option("--sides", plan.sides, "Wait for so many other sides")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  command
      ->add_option(
          "--beside", parsed.beside,
          "Send the same bytes by these in the same run: udp, tcp (plain sockets), whole (the whole message)")
      ->delimiter(',')
      ->check(CLI::IsMember({"udp", "tcp", "whole"}));
  command->add_option("--fail-if", parsed.perf.fail_if,
                      "Exit with 3 if one of these holds: 'p99 > 2 ms, lost > 0.1 %'");
  command->add_option("--svg", parsed.perf.svg, "Draw the latencies to this file");
  command->add_option("--raw", plan.raw_file, "Write the times of each sample to this file, as CSV");
  command->callback([&parsed, answers, command] {
    perf::Plan& chosen = parsed.perf.plan;
    chosen.answers = answers;
    if (!answers && command->get_option("--rate")->count() == 0) chosen.rate_hz = 0;
    for (const std::string& beside : parsed.beside) {
      chosen.beside_whole |= beside == "whole";
      chosen.beside_udp |= beside == "udp";
      chosen.beside_tcp |= beside == "tcp";
    }
    if ((chosen.beside_udp || chosen.beside_tcp) && chosen.sides > 1)
      throw CLI::ValidationError("--beside udp and tcp need one other side: leave --sides out");
    if (!parsed.host.empty()) parsed.line.common.peers.push_back(parsed.host);
    parsed.line.command = parsed.perf;
  });
}

void declare_perf(CLI::App& app, Parsed& parsed) {
  CLI::App* command = app.add_subcommand("perf", "Measure latency, rate and cost between your own machines");
  command->require_subcommand(1);
  for (const char* name : {"pong", "sub"}) {
    CLI::App* server =
        declare(*command, parsed, name, "Take part on the other machine, in all runs until Ctrl-C");
    server->callback([&parsed] {
      parsed.perf.answers = true;
      parsed.line.command = parsed.perf;
    });
  }
  declare_sender(*command, parsed, "ping", true, "Measure round trips to 'sft perf pong'");
  declare_sender(*command, parsed, "pub", false, "Measure how much arrives at 'sft perf sub'");
}

/// A command that users of the command line of ROS 2 may type, and the command of sft with the same effect.
struct Counterpart {
  std::string_view typed, command;
};
constexpr Counterpart counterparts[] = {{"topic list", "ls"},
                                        {"topic echo", "echo"},
                                        {"topic info", "info"},
                                        {"topic hz", "hz"},
                                        {"topic bw", "bw"},
                                        {"bag record", "record"},
                                        {"bag play", "play"},
                                        {"topic delay", "delay"},
                                        {"topic pub", "pub"},
                                        {"topic type", "type --name"},
                                        {"topic find", "ls types"},
                                        {"node list", "ls nodes"},
                                        {"node info", "ls endpoints"},
                                        {"interface show", "type"},
                                        {"interface list", "ls types"}};

/// Returns an error text if the first word is not a command. Returns an empty text if it is a command or an
/// option.
std::string fault_of_command(const CLI::App& app, std::span<char* const> words) {
  if (words.size() < 2 || words[1][0] == '-') return "";
  const std::string one = words[1];
  const std::string two = words.size() < 3 ? "" : one + ' ' + words[2];
  const auto* const counterpart = std::ranges::find(counterparts, two, &Counterpart::typed);
  if (counterpart != std::end(counterparts))
    return "there is no command '" + two + "'; 'sft " + std::string(counterpart->command) + "' does that";
  std::string names;
  for (const CLI::App* const command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == one) return "";
    names += (names.empty() ? "" : ", ") + command->get_name();
  }
  return "there is no command '" + one + "'; there are " + names;
}

/// Prints a mistake that CLI11 has found. The sentence of CLI11 has no full stop.
ExitCode report_mistake(const CLI::App& app, const std::string& what) {
  const auto chosen = app.get_subcommands();
  const std::string help = chosen.empty() ? "sft --help" : "sft " + chosen.front()->get_name() + " --help";
  complain(what + "; '" + help + "' lists what is possible.");
  return ExitCode::failed;
}

}  // namespace

std::variant<CommandLine, ExitCode> parse_command_line(int argc, char** argv) {
  CLI::App app(
      "Looks at the nodes, topics and samples of SFT, publishes samples, and records and plays them.", "sft");
  app.formatter(std::make_shared<HelpFormat>());
  app.set_version_flag("--version", "sft " SFT_VERSION);
  app.footer(exit_codes_help);
  app.require_subcommand(1);
  Parsed parsed;
  for (const auto add : {declare_ls, declare_info, declare_type, declare_echo, declare_pub, declare_hz,
                         declare_bw, declare_delay, declare_why, declare_top, declare_doctor, declare_record,
                         declare_play, declare_bag, declare_bridge, declare_perf}) {
    add(app, parsed);
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const std::string fault = fault_of_command(app, std::span(argv, static_cast<std::size_t>(argc)));
    if (!fault.empty()) return report_mistake(app, fault);
    if (error.get_exit_code() != 0) return report_mistake(app, error.what());
    app.exit(error);  // prints the help that the user has requested
    if (std::cout.flush()) return ExitCode::done;
    complain("the output cannot be written: " + std::generic_category().message(errno));
    return ExitCode::failed;
  }
  parsed.line.name = app.get_subcommands().front()->get_name();
  return parsed.line;
}

}  // namespace sft::tool
