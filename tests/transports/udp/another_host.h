// A second host for a test that has a host of its own (isolated_host.h).
#pragma once

#include <sched.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <functional>
#include <string>
#include <thread>

namespace sft::udp::test {

inline bool run(const std::string& command) { return std::system(command.c_str()) == 0; }

/// Runs `make` on another host, which gets the end `end` of a link and the address `address`. All that `make`
/// opens stays on that host. Returns false if no host can be made.
inline bool on_host_behind(const std::string& end, const std::string& address,
                           const std::function<void()>& make) {
  bool made = false;
  std::thread([&] {
    made = ::unshare(CLONE_NEWNET) == 0 &&
           run("nsenter -t " + std::to_string(::getpid()) + " -n ip link set " + end + " netns " +
               std::to_string(::gettid())) &&
           run("ip address add " + address + " dev " + end + " && ip link set " + end +
               " up && ip link set lo up");
    if (made) make();
  }).join();
  return made;
}

/// Makes a link and runs `make` on a host at its far end. Returns the address of that host, in
/// 10.9.`net`.0/24, or 0 if no host can be made. The near end of the link is "to`net`".
inline std::uint32_t on_another_host(unsigned net, const std::function<void()>& make) {
  const std::string number = std::to_string(net), link = "to" + number, end = "at" + number;
  const std::string prefix = "10.9." + number + ".";
  const bool made = run("ip link add " + link + " type veth peer name " + end + " && ip address add " +
                        prefix + "1/24 dev " + link + " && ip link set " + link + " up && ethtool -K " +
                        link + " tx-udp-segmentation off > /dev/null") &&
                    on_host_behind(end, prefix + "2/24", make);
  return made ? 0x0A090002U | net << 8U : 0;
}

}  // namespace sft::udp::test
