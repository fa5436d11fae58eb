#include "bench/common/roudi.h"

#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <iceoryx_hoofs/log/logmanager.hpp>
#include <iceoryx_posh/internal/roudi/roudi.hpp>
#include <iceoryx_posh/roudi/iceoryx_roudi_components.hpp>
#include <iostream>
#include <memory>
#include <string>

#include "bench/common/pair.h"
#include "bench/common/process.h"
#include "bench/common/shared.h"
#include "tests/support/isolated_host.h"

namespace sft::bench {

namespace {

constexpr std::int64_t timeout_ns = 20'000'000'000;

iox::RouDiConfig_t config() {
  iox::mepoo::MePooConfig pools;
  constexpr std::uint32_t KiB = 1024, MiB = 1024 * KiB;
  pools.addMemPool({2 * KiB, 1000});
  pools.addMemPool({20 * KiB, 1000});
  pools.addMemPool({260 * KiB, 128});
  pools.addMemPool({2 * MiB, 40});
  pools.addMemPool({9 * MiB, 10});
  const auto group = iox::posix::PosixGroup::getGroupOfCurrentProcess().getName();
  iox::RouDiConfig_t config;
  config.m_sharedMemorySegments.push_back({group, group, pools});
  return config;
}

int serve(std::atomic<bool>& serving) {
  if (unshare(CLONE_NEWNS) != 0 || !test::mount_own_memory()) return 1;
  iox::log::LogManager::GetLogManager().SetDefaultLogLevel(iox::log::LogLevel::kError,
                                                           iox::log::LogLevelOutput::kHideLogLevel);
  for (std::ostream* words : {&std::cout, &std::clog})
    words->setstate(std::ios::failbit);  // suppresses iceoryx's first line
  const auto components = std::make_unique<iox::roudi::IceOryxRouDiComponents>(config());
  constexpr bool kill_programs_at_exit = false;
  const iox::roudi::RouDi roudi(components->rouDiMemoryManager, components->portManager,
                                {iox::roudi::MonitoringMode::OFF, kill_programs_at_exit});
  serving = true;
  while (true) pause();
}

[[noreturn]] void give_up(const char* what) {
  std::fprintf(stderr, "iceoryx's daemon for Cyclone DDS: %s (root or user namespaces are needed)\n", what);
  std::exit(1);
}

}  // namespace

Roudi::Roudi() {
  if (!test::isolation_refusal().empty()) give_up("this program is not isolated");
  const Shared<std::atomic<bool>> serving;
  process_ = start_on_core(0, [&] { return serve(*serving); });
  const std::int64_t deadline = now_ns() + timeout_ns;
  while (!*serving) {
    if (now_ns() > deadline) give_up("it does not start");
    sleep_us(10'000);
  }
  mounts_ = open(("/proc/" + std::to_string(process_) + "/ns/mnt").c_str(), O_RDONLY | O_CLOEXEC);
  if (mounts_ < 0) give_up("cannot open its namespace");
}

Roudi::~Roudi() {
  close(mounts_);
  kill(process_, SIGKILL);  // the kernel frees the daemon's memory together with its namespace
  succeeds(process_);
}

void Roudi::enter() const {
  if (setns(mounts_, CLONE_NEWNS) != 0) std::abort();
}

}  // namespace sft::bench
