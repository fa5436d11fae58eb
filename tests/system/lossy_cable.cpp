#include "tests/system/lossy_cable.h"

#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstring>
#include <random>
#include <span>
#include <utility>

#include "core/platform/file_descriptor.h"
#include "tests/support/parse_datagram.h"
#include "udp_transport/wire/datagram.h"

namespace sft::test {

namespace {

constexpr std::size_t udp_header_end = 14 + 20 + 8;  // IPv4 without options
constexpr std::size_t frame_bytes_max = 2048;
constexpr int quiet_ms = 10;  // the longest time for which a frame is held back for a swap

using Frame = std::span<const std::byte>;

/// Opens the end of the cable that is in this network namespace.
core::FileDescriptor open_end(const char* interface) {
  core::FileDescriptor end(::socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, htons(ETH_P_ALL)));
  const int bytes = 64 << 20, yes = 1;
  ::setsockopt(end.get(), SOL_SOCKET, SO_RCVBUFFORCE, &bytes, sizeof bytes);
  ::setsockopt(end.get(), SOL_PACKET, PACKET_IGNORE_OUTGOING, &yes, sizeof yes);
  sockaddr_ll address{};
  address.sll_family = AF_PACKET;
  address.sll_protocol = htons(ETH_P_ALL);
  address.sll_ifindex = static_cast<int>(::if_nametoindex(interface));
  if (::bind(end.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return {};
  return end;
}

std::uint64_t not_received(const core::FileDescriptor& end) {
  tpacket_stats stats{};
  socklen_t bytes = sizeof stats;
  ::getsockopt(end.get(), SOL_PACKET, PACKET_STATISTICS, &stats, &bytes);
  return stats.tp_drops;
}

/// If the frame contains a part of a sample, returns the low half of the sample's sequence, otherwise 0.
std::uint32_t sequence_in(Frame frame) {
  constexpr std::size_t ether_type = 12, protocol = 14 + 9;
  if (frame.size() <= udp_header_end || frame[ether_type] != std::byte{8} ||
      frame[protocol] != std::byte{IPPROTO_UDP})
    return 0;
  const auto datagram = frame.subspan(udp_header_end);
  const auto part = udp::parse(datagram);
  return part ? part->label().sequence : 0;
}

/// Carries frames in one direction.
class Way {
 public:
  Way(const core::FileDescriptor& from, const core::FileDescriptor& to, LossyCable::Notes& notes)
      : from_(from), to_(to), notes_(notes) {}

  void pass_one_on(const LossyCable::Faults& faults, std::mt19937_64& random) {
    std::byte bytes[frame_bytes_max];
    const ssize_t size = ::recv(from_.get(), bytes, sizeof bytes, MSG_TRUNC);
    if (size <= 0 || static_cast<std::size_t>(size) > sizeof bytes) return static_cast<void>(++notes_.failed);
    const Frame frame(bytes, static_cast<std::size_t>(size));
    const auto happens = [&](double probability) {
      return notes_.bad && std::uniform_real_distribution<>()(random) < probability;
    };
    if (happens(faults.loss)) return lose(frame);
    if (kept_.empty() && happens(faults.swap)) {
      kept_.assign(frame.begin(), frame.end());
      return static_cast<void>(++notes_.swapped);
    }
    send(frame);
    if (happens(faults.repetition)) {
      send(frame);
      ++notes_.repeated;
    }
    send_kept();
  }
  void send_kept() {
    if (!kept_.empty()) send(std::exchange(kept_, {}));
  }
  const core::FileDescriptor& from() const { return from_; }

 private:
  void lose(Frame frame) {
    ++notes_.lost;
    const std::uint32_t sequence = sequence_in(frame);
    if (sequence != 0 && sequence < notes_.harmed.size()) notes_.harmed[sequence] = true;
  }
  void send(Frame frame) {
    const ssize_t sent = ::send(to_.get(), frame.data(), frame.size(), 0);
    if (sent != static_cast<ssize_t>(frame.size())) ++notes_.failed;
  }

  const core::FileDescriptor& from_;
  const core::FileDescriptor& to_;
  LossyCable::Notes& notes_;
  std::vector<std::byte> kept_;
};

}  // namespace

Result<std::unique_ptr<LossyCable>> LossyCable::create(const Faults& faults, std::uint64_t seed) {
  auto middle = hosts::NetworkNamespace::create();
  if (!middle) return tl::unexpected(middle.error());
  std::vector<hosts::NetworkNamespace> hosts;
  for (int i = 0; i < 2; ++i) {
    auto host = hosts::NetworkNamespace::create();
    if (!host) return tl::unexpected(host.error());
    hosts.push_back(std::move(*host));
  }
  std::unique_ptr<LossyCable> cable(new LossyCable(std::move(*middle), std::move(hosts)));
  for (std::size_t number : {0U, 1U}) {
    if (auto plugged = cable->plug_in(number); !plugged) return tl::unexpected(plugged.error());
  }
  cable->process_ = fork();
  if (cable->process_ == 0) cable->pass_on(faults, seed);
  return cable;
}

LossyCable::~LossyCable() {
  if (process_ <= 0) return;
  kill(process_, SIGKILL);
  waitpid(process_, nullptr, 0);
}

/// Connects an end of the cable to a host. The process of the cable carries whole frames, so the interfaces
/// must add checksums and split trains of datagrams into frames.
Result<void> LossyCable::plug_in(std::size_t number) const {
  const std::string end = "end" + std::to_string(number);
  const std::string address = hosts::EmulatedNetwork::address(number);
  const Result<void> laid = middle_.run({"sh", "-ec",
                                         "ip link add " + end + " type veth peer name eth0 netns " +
                                             hosts_[number].path() + "; ip link set dev " + end +
                                             " addrgenmode none; ip link set dev " + end + " promisc on up"});
  if (!laid) return laid;
  return hosts_[number].run({"sh", "-ec",
                             "ip link set dev lo up; ip link set dev eth0 addrgenmode none; "
                             "ip address add " +
                                 address +
                                 "/24 dev eth0; ip link set dev eth0 up; ethtool -K eth0 tx off "
                                 "tx-udp-segmentation off > /dev/null"});
}

void LossyCable::pass_on(const Faults& faults, std::uint64_t seed) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (!middle_.enter()) _exit(1);
  const core::FileDescriptor ends[] = {open_end("end0"), open_end("end1")};
  if (!ends[0] || !ends[1]) _exit(1);
  Way ways[] = {{ends[0], ends[1], *notes_}, {ends[1], ends[0], *notes_}};
  std::mt19937_64 random(seed);
  notes_->ready = true;
  for (;;) {
    pollfd waiting[] = {{ends[0].get(), POLLIN, 0}, {ends[1].get(), POLLIN, 0}};
    const int ready = ::poll(waiting, 2, quiet_ms);
    for (std::size_t i = 0; i < 2; ++i) {
      if (ready == 0) ways[i].send_kept();
      if ((waiting[i].revents & POLLIN) != 0) ways[i].pass_one_on(faults, random);
    }
    if (ready == 0) notes_->failed += not_received(ends[0]) + not_received(ends[1]);
  }
}

}  // namespace sft::test
