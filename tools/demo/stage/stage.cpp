#include "tools/demo/stage/stage.h"

#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <random>
#include <thread>

#include "tools/hosts/own_host.h"
#include "tools/hosts/system_error.h"

namespace sft::demo {

namespace {

/// Of each subscriber; the publisher runs on the last one.
constexpr std::array<const char*, 5> host_names{"monitor", "cockpit", "logger", "nav", "lidar"};
constexpr std::chrono::seconds patience_with_hosts{8};  // in which nodes take their leave, and daemons end
constexpr std::chrono::milliseconds moment{10};
constexpr unsigned publishers_shm_mebibytes = 1024;  // for some samples of 6 MB

/// Other programs of this machine may use the default domain. They rarely use one of the upper domains.
std::uint32_t random_domain() {
  std::random_device random;
  return std::uniform_int_distribution<std::uint32_t>(100, 200)(random);
}

/// A host has a /proc of its own, in which programs do not find the folder of sftd.
void name_the_daemon() {
  const std::filesystem::path daemon = hosts::program_directory() / "sftd";
  std::error_code error;
  if (std::filesystem::exists(daemon, error)) setenv("SFT_DAEMON", daemon.c_str(), 0);
}

}  // namespace

Result<std::unique_ptr<Stage>> Stage::set_up(const PublishingPlan& plan, bool arr) {
  name_the_daemon();
  void* memory = mmap(nullptr, sizeof(Board), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return hosts::system_error("shared memory for reports");
  std::unique_ptr<Stage> stage(new Stage(new (memory) Board));
  if (const Result<void> possible = try_isolation(); possible) {
    if (const Result<void> root = become_root(); !root) return tl::unexpected(root.error());
    auto network = hosts::EmulatedNetwork::create(host_names.size());
    if (!network) return tl::unexpected(network.error());
    stage->network_ = std::move(*network);
  } else {
    stage->why_not_ = possible.error().message;
  }
  const Result<void> started = stage->start(plan, arr);
  if (!started) return tl::unexpected(started.error());
  return stage;
}

Result<void> Stage::start(const PublishingPlan& plan, bool arr) {
  const std::uint32_t domain = real_hosts() ? 0 : random_domain();
  for (std::size_t i = 0; i < host_names.size(); ++i) {
    const SubscriberRole& subscriber = subscriber_roles[i];
    const bool local = i + 1 == host_names.size();
    NodePlan node{.name = subscriber.name, .domain = domain};
    if (!local && !real_hosts()) node.transport = TransportChoice::udp;
    // Samples for the subscriber would come over this interface.
    if (real_hosts()) node.interface = local ? "lo" : hosts::host_interface;
    std::vector<Role> roles{{node.name, [&, node, arr] { return subscriber.run(node, arr, *board_, i); }}};
    HostSettings settings{.network = real_hosts() ? &network_->host(i) : nullptr};
    if (local) {
      roles.push_back(
          {"lidar", [&] { return run_publisher({.name = "lidar", .domain = domain}, plan, *board_); }});
      settings.shm_mebibytes = publishers_shm_mebibytes;
    }
    const Result<pid_t> first_process = start_host(settings, roles);
    if (!first_process) return tl::unexpected(first_process.error());
    processes_.push_back(*first_process);
    subscribers_.push_back({subscriber.name, host_names[i], subscriber.purpose, local});
  }
  return {};
}

Stage::~Stage() {
  order(Order::end);
  const auto deadline = Clock::now() + patience_with_hosts;
  for (const pid_t process : processes_) {
    while (waitpid(process, nullptr, WNOHANG) == 0) {
      if (Clock::now() > deadline) kill(process, SIGTERM);
      std::this_thread::sleep_for(moment);
    }
  }
  munmap(board_, sizeof(Board));
}

Result<void> Stage::update() {
  board_->publisher.read(publisher_);
  for (std::size_t i = 0; i < subscribers_.size(); ++i) {
    Subscriber& subscriber = subscribers_[i];
    board_->subscribers[i].read(subscriber.report);
    for (const Route& route : publisher_.routes) {
      if (route.name.str() == subscriber.name) subscriber.route = route;
    }
    if (waitpid(processes_[i], nullptr, WNOHANG) == 0) continue;
    processes_.erase(processes_.begin() + static_cast<std::ptrdiff_t>(i));
    return fail(Errc::unavailable, "the processes of host " + subscriber.host + " have ended unexpectedly");
  }
  return {};
}

}  // namespace sft::demo
