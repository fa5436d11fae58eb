// A second host for a test that has one of its own (isolated_host.h).
#pragma once

#include <sched.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <functional>
#include <string>
#include <thread>

namespace sft::udp::test {

inline bool run(const char* command) { return std::system(command) == 0; }

/// Makes something on another host, behind a link of their own: what it opens there stays there. Returns the
/// address of that host, in 10.9.`net`.0/24; 0 where there can be none. Our end of the link is "to`net`".
inline std::uint32_t on_another_host(unsigned net, const std::function<void()>& make) {
  const std::string number = std::to_string(net), link = "to" + number, end = "at" + number;
  const std::string prefix = "10.9." + number + ".";
  if (!run(("ip link add " + link + " type veth peer name " + end + " && ip address add " + prefix +
            "1/24 dev " + link + " && ip link set " + link + " up && ethtool -K " + link +
            " tx-udp-segmentation off > /dev/null")
               .c_str()))
    return 0;
  bool made = false;
  std::thread([&] {
    const std::string hand_over = "nsenter -t " + std::to_string(::getpid()) + " -n ip link set " + end +
                                  " netns " + std::to_string(::gettid());
    const std::string set_up = "ip address add " + prefix + "2/24 dev " + end + " && ip link set " + end +
                               " up && ip link set lo up";
    made = ::unshare(CLONE_NEWNET) == 0 && run(hand_over.c_str()) && run(set_up.c_str());
    if (made) make();
  }).join();
  return made ? 0x0A090002U | net << 8U : 0;
}

}  // namespace sft::udp::test
