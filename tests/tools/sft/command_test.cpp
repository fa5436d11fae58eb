// The command as a whole: its arguments, its exit codes, and its use of a terminal. Also tests the verbs
// doctor and top.
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <regex>
#include <sstream>
#include <trajectory_msgs/msg/MultiDOFJointTrajectoryPoint.hpp>

#include "tests/support/isolated_host.h"
#include "tests/tools/sft/tool_fixture.h"

namespace sft::test {
namespace {

using Clock = std::chrono::steady_clock;

class CommandTest : public ToolTest {
 protected:
  Publisher<PointCloud2> points = robot.publisher<PointCloud2>("points").value();
};

TEST_F(CommandTest, WrongUsageIsOneSentenceAndExitCodeTwo) {
  const std::vector<std::vector<std::string>> wrong{{},
                                                    {"dance"},
                                                    {"echo"},
                                                    {"echo", "points", "--fast"},
                                                    {"echo", "points", "--json", "--csv"},
                                                    {"ls", "robots"},
                                                    {"pub", "points"},
                                                    {"pub", "points", "std_msgs/Empty", "--once", "-n", "2"},
                                                    {"pub", "points", "std_msgs/Empty", "-r", "0"},
                                                    {"ls", "--domain", "300"},
                                                    {"hz", "points", "--for", "soon"}};
  for (const auto& arguments : wrong) {
    const Ended ended = run_tool(arguments);
    EXPECT_EQ(ended.code, 2) << ended.err;
    EXPECT_EQ(ended.out, "");
    EXPECT_THAT(ended.err, StartsWith("sft: "));
    EXPECT_EQ(std::count(ended.err.begin(), ended.err.end(), '\n'), 1) << ended.err;
  }
}

TEST_F(CommandTest, AnOutputThatCannotBeWrittenIsAnErrorWithItsReason) {
  auto busy = robot.publisher<PointCloud2>("busy").value();
  const Publishing publishing(busy, cloud());
  const std::vector<std::vector<std::string>> commands{{"--help"},
                                                       {"--version"},
                                                       {"echo", "--help"},
                                                       {"ls"},
                                                       {"info", "points"},
                                                       {"type", "points"},
                                                       {"why", "points"},
                                                       {"doctor"},
                                                       {"echo", "busy", "--json"},
                                                       {"hz", "busy"},
                                                       {"bw", "busy"},
                                                       {"top", "--json"}};
  for (const auto& arguments : commands) {
    SCOPED_TRACE(arguments.front());
    const Ended ended = ToolProcess(arguments, ToolProcess::On::full_disk).end();
    EXPECT_EQ(ended.code, 2);
    EXPECT_THAT(ended.err, HasSubstr("sft: the output cannot be written"));
  }
}

TEST_F(CommandTest, AWordThatIsNoCommandIsNamedAndACommandOfRos2LeadsToItsOwn) {
  const Ended unknown = run_tool({"dance", "points"});
  EXPECT_THAT(unknown.err, StartsWith("sft: there is no command 'dance'; there are ls, info, type, echo"));
  const Ended of_ros2 = run_tool({"topic", "list", "-t"});
  EXPECT_EQ(of_ros2.code, 2);
  EXPECT_THAT(of_ros2.err, StartsWith("sft: there is no command 'topic list'; 'sft ls' does that;"));
  EXPECT_THAT(run_tool({"bag", "record", "points"}).err, HasSubstr("'sft record' does that"));
  EXPECT_THAT(run_tool({"interface", "show", "sensor_msgs/Image"}).err, HasSubstr("'sft type' does that"));
}

TEST_F(CommandTest, HelpTellsOfExitCodes) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"--help"}, std::vector<std::string>{"echo", "--help"}}) {
    const Ended ended = run_tool(arguments);
    EXPECT_EQ(ended.code, 0);
    EXPECT_THAT(ended.out, HasSubstr("Exit codes: 0 done"));
  }
}

/// Returns the lines of `out` without escape sequences and carriage returns.
std::vector<std::string> shown_lines(const std::string& out) {
  std::istringstream text(std::regex_replace(out, std::regex("\x1b\\[[0-9;]*m|\r"), ""));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

TEST_F(CommandTest, TheHelpOfEachSubcommandFitsEightyColumns) {
  std::vector<std::vector<std::string>> helps{{"--help"}};
  for (const char* command : {"ls", "info", "type", "echo", "pub", "hz", "bw", "delay", "why", "top",
                              "doctor", "record", "play", "bag", "perf"})
    helps.push_back({command, "--help"});
  helps.push_back({"perf", "ping", "--help"});
  for (const auto& arguments : helps) {
    const std::vector<std::string> lines = shown_lines(run_tool(arguments).out);
    EXPECT_GT(lines.size(), 10U);
    for (const std::string& line : lines) EXPECT_LE(line.size(), 80U) << arguments[0] << ": " << line;
  }
}

TEST_F(CommandTest, WhatIsPrintedOnATerminalFitsIt) {
  using Trajectory = trajectory_msgs::msg::MultiDOFJointTrajectoryPoint;
  const std::string far = "building/floor/room/robot/arm/gripper/finger/trajectory";
  std::vector<Publisher<Trajectory>> others;
  for (const char* end : {"", "_next", "_last"})
    others.push_back(robot.publisher<Trajectory>(far + end).value());
  auto monitor = open("logger").subscriber<PointCloud2>("points", {.max_rate_hz = 5}).value();
  const Publishing publishing(points, cloud(), 10ms, true);
  const std::vector<std::vector<std::string>> commands{{"ls"},
                                                       {"ls", "nodes"},
                                                       {"ls", "types"},
                                                       {"ls", "endpoints"},
                                                       {"info", "points"},
                                                       {"info", far},
                                                       {"hz", "points", "--for", "1.5"},
                                                       {"bw", "points", "--for", "1.5"},
                                                       {"delay", "points", "--for", "1.5"},
                                                       {"doctor"}};
  std::vector<std::unique_ptr<ToolProcess>> tools;
  for (const auto& arguments : commands)
    tools.push_back(std::make_unique<ToolProcess>(arguments, ToolProcess::On::terminal));
  for (std::size_t i = 0; i < commands.size(); ++i) {
    const std::vector<std::string> lines = shown_lines(tools[i]->end().out);
    EXPECT_FALSE(lines.empty());
    for (const std::string& line : lines) EXPECT_LE(line.size(), 80U) << commands[i][0] << ": " << line;
  }
}

TEST_F(CommandTest, CtrlCEndsEachAndItsSubscribersAreGone) {
  const Publishing publishing(points, cloud(), 10ms, true);
  const std::vector<std::vector<std::string>> commands{{"echo", "points", "--fields", "width"},
                                                       {"hz", "points"},
                                                       {"bw", "points"},
                                                       {"delay", "points"},
                                                       {"top", "--json"}};
  for (const auto& arguments : commands) {
    ToolProcess tool(arguments);
    ASSERT_TRUE(tool.prints("\n")) << arguments[0];
    tool.send(SIGINT);
    EXPECT_EQ(tool.end().code, 0) << arguments[0];
    EXPECT_TRUE(eventually([&] { return points.status().readers.empty(); })) << arguments[0];
  }
}

/// Returns true if the process has a handler for SIGINT, or blocks it, so that SIGINT does not kill it.
bool handles_interrupts(pid_t process) {
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  for (std::string line; std::getline(status, line);) {
    const bool is_mask = line.starts_with("SigCgt:") || line.starts_with("SigBlk:");
    if (is_mask && (std::stoull(line.substr(7), nullptr, 16) >> (SIGINT - 1) & 1) != 0) return true;
  }
  return false;
}

TEST_F(CommandTest, CtrlCEndsWhatWaits) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"ls", "--wait", "3600"},
        std::vector<std::string>{"echo", "nowhere", "--timeout", "3600"}}) {
    ToolProcess tool(arguments);
    ASSERT_TRUE(eventually([&] { return handles_interrupts(tool.id()); }));
    // Waits 500 ms, so that the command is waiting, too.
    ASSERT_FALSE(eventually([&] { return false; }, 500ms));
    tool.send(SIGINT);
    EXPECT_GE(tool.end().code, 0);
  }
}

TEST_F(CommandTest, TopShowsAllOnTheScreenEndsOnQAndGivesTheTerminalBack) {
  auto monitor = open("logger").subscriber<PointCloud2, F::width>("points").value();
  const Publishing publishing(points, cloud());
  ToolProcess top({"top"}, ToolProcess::On::terminal);
  ASSERT_TRUE(top.prints("lidar -> logger")) << top.out();
  EXPECT_THAT(top.out(), HasSubstr("\x1b[?1049h"));
  EXPECT_TRUE(top.prints("1 topic, 1 pair"));
  EXPECT_TRUE(top.prints(" Hz"));
  EXPECT_TRUE(top.prints("WITHHELD"));
  EXPECT_TRUE(top.prints(" %")) << "what was saved is told, too";
  EXPECT_FALSE(top.echoes());
  top.press("q");
  ASSERT_TRUE(top.prints("\x1b[?1049l"));
  EXPECT_EQ(top.end().code, 0);
  EXPECT_TRUE(top.echoes());
}

TEST_F(CommandTest, TopWritesJsonForPrograms) {
  auto monitor = open("logger").subscriber<PointCloud2, F::width>("points").value();
  const Publishing publishing(points, cloud(), 20ms);
  const Ended ended = run_tool({"top", "--json", "--for", "5"});
  EXPECT_EQ(ended.code, 0);
  std::istringstream lines(ended.out);
  Json last;
  for (std::string line; std::getline(lines, line);) last = Json::parse(line);
  EXPECT_EQ(last["topics"][0]["topic"], "points");
  EXPECT_GT(last["topics"][0]["samples_per_s"].get<double>(), 10);
  EXPECT_LT(last["topics"][0]["samples_per_s"].get<double>(), 65) << "50 are published";
  const Json& pair = last["topics"][0]["pairs"].at(0);
  EXPECT_GT(pair["sent"], 100);
  EXPECT_GT(pair["bytes_saved"], 100'000);
  EXPECT_TRUE(pair["lost"].is_number());
  EXPECT_EQ(run_tool({"top"}).code, 2);  // top needs a terminal
}

TEST_F(CommandTest, ColoursAreForTerminalsAndCanBeRuledOut) {
  const std::string escape = "\x1b[";
  EXPECT_EQ(run_tool({"ls"}).out.find(escape), std::string::npos);
  ToolProcess colored({"ls"}, ToolProcess::On::terminal);
  EXPECT_TRUE(colored.prints("points"));
  EXPECT_THAT(colored.out(), HasSubstr(escape));
  ToolProcess plain({"ls", "--no-color"}, ToolProcess::On::terminal);
  EXPECT_TRUE(plain.prints("points"));
  EXPECT_EQ(plain.out().find(escape), std::string::npos);
}

TEST_F(CommandTest, DoctorTellsOfEachPartAndItsExitCodeIsTheWorst) {
  const Ended ended = run_tool({"doctor", "--json"});
  const Json json = Json::parse(ended.out);
  int worst = 0;
  std::set<std::string> parts;
  for (const Json& check : json["checks"]) {
    const std::string health = check["health"];
    worst = std::max(worst, health == "ok" ? 0 : health == "warning" ? 1 : 2);
    parts.insert(check["check"]);
    EXPECT_EQ(check["to_do"] == "", health == "ok") << check.dump();
  }
  EXPECT_EQ(ended.code, worst);
  for (const char* part :
       {"interfaces", "multicast", "udp", "io_uring", "GSO", "GRO", "huge pages", "memlock", "buffers",
        "/proc", "/tmp", "/dev/shm", "sftd", "chunks", "users", "clock", "kernel", "loopback", "domain"}) {
    EXPECT_TRUE(parts.contains(part)) << part;
  }
  const Ended text = run_tool({"doctor"});
  EXPECT_EQ(text.code, ended.code);
  std::istringstream lines(text.out);
  for (std::string line; std::getline(lines, line);) {
    EXPECT_TRUE(line.starts_with("ok ") || line.starts_with("warning ") || line.starts_with("error "))
        << line;
  }
}

TEST_F(CommandTest, DoctorSaysOfEachQuickPathThatItIsUsedOrWhyNot) {
  const Json json = Json::parse(run_tool({"doctor", "--json"}).out);
  std::size_t reported = 0;
  for (const Json& check : json["checks"]) {
    if (!std::set<std::string>{"io_uring", "GSO", "GRO", "huge pages"}.contains(check["check"])) continue;
    const std::string text = check["text"];
    EXPECT_TRUE(text == "used" || text.starts_with("not used: ")) << check;
    EXPECT_EQ(text == "used", check["health"] == "ok") << check;
    ++reported;
  }
  EXPECT_EQ(reported, 4U);
}

TEST_F(CommandTest, DoctorWarnsOfAnInterfaceThatIsNotThereAndOfNoneThatIs) {
  for (const auto& [interface, health] : {std::pair("eth9", "warning"), std::pair("lo", "ok")}) {
    const Json json = Json::parse(run_tool({"doctor", "--json", "--interface", interface}).out);
    const auto named = [&](const Json& check) { return check["check"] == "interfaces"; };
    const auto found = std::ranges::find_if(json["checks"], named);
    ASSERT_NE(found, json["checks"].end());
    EXPECT_EQ((*found)["health"], health) << *found;
  }
}

TEST_F(CommandTest, DoctorFindsThatTheLoopbackIsDown) {
  if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
  ifreq loopback{};
  std::strcpy(loopback.ifr_name, "lo");
  const int control = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ASSERT_EQ(ioctl(control, SIOCGIFFLAGS, &loopback), 0);
  loopback.ifr_flags = static_cast<short>(loopback.ifr_flags & ~IFF_UP);
  ASSERT_EQ(ioctl(control, SIOCSIFFLAGS, &loopback), 0);
  close(control);
  const Ended ended = run_tool({"doctor"});
  EXPECT_EQ(ended.code, 2);
  EXPECT_THAT(ended.out, HasSubstr("error   loopback    the interface lo is down"));
}

Json doctors_check(const std::string& name) {
  const Json json = Json::parse(run_tool({"doctor", "--json"}).out);
  const auto is_it = [&](const Json& check) { return check["check"] == name; };
  const auto found = std::ranges::find_if(json["checks"], is_it);
  return found == json["checks"].end() ? Json() : *found;
}

TEST_F(CommandTest, DoctorComparesWhatPublishersOfTheHostAnnounceWithTheLargestChunk) {
  if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
  Node camera = open("camera", TransportChoice::automatic);
  ASSERT_TRUE(eventually([&] { return camera.status().shm_ready; })) << camera.status().shm;
  const auto small = camera.publisher<PointCloud2>("small", {.max_sample_bytes = 1 << 20}).value();
  ASSERT_TRUE(eventually([] { return doctors_check("chunks")["text"] != ""; }));
  const auto usual = camera.publisher<PointCloud2>("usual").value();
  EXPECT_EQ(doctors_check("chunks")["health"], "ok")
      << "the topic 'points' has no shared memory, and the default says nothing of samples";
  const auto images = camera.publisher<PointCloud2>("images", {.max_sample_bytes = 63 << 20}).value();
  EXPECT_TRUE(eventually([] { return doctors_check("chunks")["health"] == "warning"; }));
  const Json found = doctors_check("chunks");
  EXPECT_THAT(found["text"].get<std::string>(), HasSubstr("announce larger ones: images")) << found;
  EXPECT_THAT(found["to_do"].get<std::string>(), HasSubstr("total_mib")) << found;
}

TEST_F(CommandTest, WhyAndDoctorNameSamplesThatAreTooLargeForSharedMemoryAndSayWhatToDo) {
  if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
  const ShmOfSize shm(400);  // the largest chunk of this memory has 17 MiB
  Node camera = open("camera", TransportChoice::automatic);
  Node viewer = open("viewer", TransportChoice::automatic);
  auto images = camera.publisher<PointCloud2>("images").value();
  auto all = viewer.subscriber<PointCloud2>("images").value();
  const auto is_in_memory = [&] {
    const auto readers = images.status().readers;
    return readers.size() == 1 && readers[0].served && readers[0].transport == TransportKind::shm;
  };
  ASSERT_TRUE(eventually(is_in_memory));
  PointCloud2 image;
  image.data.resize(40 << 20);
  EXPECT_EQ(images.publish(image), PublishStatus::ok);
  ASSERT_EQ(images.status().diverted.too_large, 1U) << "the largest chunk of " << camera.status().shm;
  std::string why;
  EXPECT_TRUE(eventually([&] {
    why = run_tool({"why", "images"}).out;
    return why.find("diverted") != why.npos;
  })) << why;
  const std::string joined = std::regex_replace(why, std::regex("\\s+"), " ");
  EXPECT_THAT(joined, HasSubstr("1 of these went by UDP: the largest chunk of shared memory has room for "));
  EXPECT_THAT(joined,
              HasSubstr("and samples have up to 41.9 MB: enlarge /dev/shm, or set total_mib or [[pool]]"));
  EXPECT_TRUE(eventually([] { return doctors_check("chunks")["health"] == "warning"; }));
  EXPECT_THAT(doctors_check("chunks")["text"].get<std::string>(),
              HasSubstr("larger samples went by UDP: images (41.9 MB)"));
}

TEST_F(CommandTest, DoctorNamesTheChunksThatWereAllInUse) {
  if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
  Node camera = open("camera", TransportChoice::shm);
  ASSERT_TRUE(eventually([&] { return camera.status().shm_ready; })) << camera.status().shm;
  auto images = camera.publisher<PointCloud2>("images", {.max_sample_bytes = 16'000'000}).value();
  auto all = camera.subscriber<PointCloud2>("images", {.depth_bytes = 0}).value();
  ASSERT_TRUE(images.wait_for_subscribers(1, hang_timeout));
  PointCloud2 image;
  image.data.resize(15'000'000);
  EXPECT_TRUE(eventually([&] { return images.publish(image) == PublishStatus::no_memory; }));
  EXPECT_TRUE(eventually([] { return doctors_check("chunks")["health"] == "warning"; }));
  EXPECT_THAT(doctors_check("chunks")["text"].get<std::string>(), HasSubstr("have been in use at a time: "));
}

TEST_F(CommandTest, DoctorFindsTooLittleSharedMemory) {
  if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
  const ShmOfSize small(16);
  const Ended ended = run_tool({"doctor"});
  EXPECT_EQ(ended.code, 2);
  EXPECT_THAT(ended.out, HasSubstr("error   /dev/shm"));
}

TEST_F(CommandTest, NobodyInADomainIsExitCodeOne) {
  const Ended ended = run_tool({"ls", "--domain", "17", "--json"});
  EXPECT_EQ(ended.code, 1);
  EXPECT_EQ(Json::parse(ended.out)["topics"], Json::array());
  EXPECT_EQ(Json::parse(ended.out)["domain"], 17);
  for (const char* arguments : {"topics", "nodes"}) {
    const Ended text = run_tool({"ls", arguments, "--domain", "17"});
    EXPECT_EQ(text.code, 1);
    EXPECT_THAT(text.err, HasSubstr("No publisher and no subscriber was found in domain 17;"));
  }
  EXPECT_THAT(run_tool({"ls", "--names", "--domain", "17"}).err, HasSubstr("in domain 17;"));
}

TEST_F(CommandTest, BashCompletesSubcommandsOptionsTopicsAndFields) {
  const std::string script =
      "PATH=" + program_directory() +
      ":$PATH; source " SFT_COMPLETION
      "; complete_words() { COMP_WORDS=(\"$@\"); COMP_CWORD=$(($# - 1)); _sft; "
      "printf \"%s\\n\" \"${COMPREPLY[@]}\"; };"
      "complete_words sft ec; complete_words sft echo /po; complete_words sft echo points --on;"
      "complete_words sft echo points --fields fields[].na; complete_words sft ls ty; "
      "complete_words sft pub /po; complete_words sft pub points sensor_msgs/PointCloud2; complete_words sft "
      "perf po; "
      "complete_words sft perf ping --fail";
  FILE* const pipe = popen(("bash -c '" + script + "'").c_str(), "r");
  if (pipe == nullptr) GTEST_SKIP() << "no bash";
  std::string out;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) out += static_cast<char>(c);
  pclose(pipe);
  EXPECT_EQ(
      out,
      "echo\n/points\n--once\nfields[].name\ntypes\n/points\nsensor_msgs/PointCloud2\npong\n--fail-if\n");
}

}  // namespace
}  // namespace sft::test
