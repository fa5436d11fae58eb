#include "bench/bridge/radio.h"

#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "bench/common/hosts.h"
#include "tests/support/isolated_host.h"

namespace sft::bench {

namespace {

void check_link(const Result<void>& done) {
  if (done) return;
  std::fprintf(stderr, "the link cannot be made bad: %s\n", done.error().message.c_str());
  std::exit(1);
}

}  // namespace

Radio make_radio() {
  auto radio = std::make_shared<const hosts::EmulatedNetwork>(make_hosts(2, Trains::cut));
  for (const std::size_t host : {robot_host, station_host}) {
    check_link(radio->host(host).run({"nft", "-f", "-"},
                                     "table netdev loss {\n"
                                     "  chain arriving {\n"
                                     "    type filter hook ingress device eth0 priority 0;\n"
                                     "    numgen random mod 100 < 1 drop\n"
                                     "  }\n"
                                     "}\n"));
    check_link(radio->run_on_switch({"tc", "qdisc", "add", "dev", hosts::EmulatedNetwork::port(host), "root",
                                     "tbf", "rate", "50mbit", "burst", "32kb", "latency", "100ms"}));
  }
  return radio;
}

void yield_to_robot() {
  const sched_param parameters{};
  sched_setscheduler(0, SCHED_IDLE, &parameters);
}

void be_silent() {
  const int nothing = open("/dev/null", O_WRONLY | O_CLOEXEC);
  dup2(nothing, STDOUT_FILENO);
  dup2(nothing, STDERR_FILENO);
}

int execute(const std::string& program, std::vector<std::string> arguments) {
  const std::string path = test::program_directory() + "/" + program;
  arguments.insert(arguments.begin(), path);
  std::vector<char*> words;
  for (std::string& argument : arguments) words.push_back(argument.data());
  words.push_back(nullptr);
  execv(path.c_str(), words.data());
  return 127;
}

Bridges::Bridges(const Radio& radio) : processes_(radio, 1) {
  constexpr const char* link_domain = "50";
  of_robot_ = processes_.start(robot_host, [] {
    be_silent();
    return execute(
        "sft", {"bridge", "--from", std::to_string(robot_domain), "--from-dds", "never", "--to", link_domain,
                "--to-dds", "never", "--reliable", "points -> robot/points", "small"});
  });
  processes_.start(station_host, [] {
    be_silent();
    yield_to_robot();
    return execute("sft",
                   {"bridge", "--from", link_domain, "--from-dds", "never", "--to",
                    std::to_string(station_domain), "robot/points{data{x,y,z}}[::4] -> points", "small"});
  });
}

}  // namespace sft::bench
