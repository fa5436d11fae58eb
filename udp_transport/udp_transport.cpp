#include "udp_transport/udp_transport.h"

#include <array>
#include <optional>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "core/platform/huge_pages.h"
#include "core/sync/mutex.h"
#include "udp_transport/io/interfaces.h"
#include "udp_transport/io/socket_io.h"
#include "udp_transport/io/udp_socket.h"
#include "udp_transport/io/uring_io.h"
#include "udp_transport/receive/receive_loop.h"
#include "udp_transport/send/answers.h"
#include "udp_transport/udp_reader.h"
#include "udp_transport/udp_writer.h"

namespace sft::udp {

namespace {

/// Returns advice if the system grants a smaller receive buffer than requested, so that large samples may
/// get lost; otherwise empty.
std::string note_on_buffer(const UdpOptions& options, const UdpSocket& socket) {
  if (socket.receive_buffer_bytes >= options.receive_buffer_bytes) return "";
  return "; the system grants its socket " + std::to_string(socket.receive_buffer_bytes) + " of " +
         std::to_string(options.receive_buffer_bytes) +
         " bytes: for large samples raise it with 'sysctl -w " +
         "net.core.rmem_max=" + std::to_string(options.receive_buffer_bytes / 2) + "'";
}

/// Readers and writers of the transport share its receiving half and its sending half. They can outlive the
/// transport, and then do nothing.
class UdpTransport final : public core::Network {
 public:
  UdpTransport(const UdpOptions& options, const UdpSocket& socket, std::string description,
               std::vector<NodeStatus::QuickPath> quick_paths, std::shared_ptr<ReceiveLoop> receiver,
               std::shared_ptr<SendSide> send_side)
      : quick_paths_(std::move(quick_paths)),
        description_(std::move(description) + ", port " + std::to_string(socket.port) +
                     (socket.family == AF_INET && options.bind_address.is_any() ? ", IPv4 only" : "") +
                     note_on_buffer(options, socket)),
        max_sample_bytes_(options.max_sample_bytes),
        bound_to_(options.bind_address),
        advertised_(options.advertised_addresses),
        interfaces_(options.interfaces),
        port_(socket.port),
        family_(socket.family),
        receive_buffer_bytes_(socket.receive_buffer_bytes),
        receiver_(std::move(receiver)),
        send_side_(std::move(send_side)) {}

  ~UdpTransport() override {
    receiver_->stop();
    send_side_->sender.stop();
  }

  std::size_t max_sample_bytes() const noexcept override { return max_sample_bytes_; }

  core::Availability poll(std::chrono::steady_clock::time_point now) override {
    send_side_->writers.maintain(now);
    const bool anew = std::exchange(network_has_changed_, false);
    if (anew || now - destinations_looked_after_at_ >= PathMtu::search_pause) {
      destinations_looked_after_at_ = now;
      send_side_->destinations.look_after(now, anew, remarks_);
    }
    if (send_side_->pool != nullptr) send_side_->pool->stock();
    return receiver_->health().is_broken ? core::Availability::unavailable : core::Availability::ready;
  }

  std::vector<Remark> take_remarks() override { return std::exchange(remarks_, {}); }

  std::chrono::steady_clock::time_point next_poll() const override { return send_side_->writers.next(); }

  std::string description() const override {
    const auto [is_broken, fell_back] = receiver_->health();
    if (is_broken) return description_ + ": the system refused to go on receiving; open the transport again";
    if (fell_back.empty()) return description_;
    return description_ +
           ", which receives by plain sockets since io_uring cannot be used any more: " + fell_back;
  }

  void add_to(NodeStatus& status) const override {
    status.quick_paths = quick_paths_;
    NodeStatus::QuickPath& io_uring = status.quick_paths.front();
    if (io_uring.why_not.empty()) io_uring.why_not = receiver_->health().fell_back;
    status.io_uring_in_use = io_uring.why_not.empty();
  }

  std::vector<core::UdpAddress> addresses() const override {
    std::vector<core::IpAddress> hosts = advertised_;
    if (hosts.empty() && !bound_to_.is_any()) hosts.push_back(bound_to_);
    std::vector<core::UdpAddress> addresses;
    for (const core::IpAddress& host : hosts) addresses.push_back({host, port_, receive_buffer_bytes_});
    if (!addresses.empty()) return addresses;
    for (const core::Link& link : links())
      addresses.push_back({link.ip, port_, receive_buffer_bytes_, link.wireless});
    // So nodes of this host can reach this node even if none of the chosen interfaces exists.
    if (addresses.empty()) addresses.push_back({core::loopback_ipv4, port_, receive_buffer_bytes_});
    return addresses;
  }

  std::vector<core::Link> links() const override {
    std::optional<std::vector<core::Link>> links = own_links(interfaces_);
    const core::Lock lock(links_mutex_);
    if (!links) return links_;
    if (family_ == AF_INET) std::erase_if(*links, [](const core::Link& link) { return !link.ip.is_ipv4(); });
    links_ = *links;
    return *links;
  }
  void wake_receiver() noexcept override { receiver_->wake_receiver(); }
  bool network_changed() noexcept override {
    const std::uint64_t changes = send_side_->network_watch.changes();
    const bool changed = std::exchange(network_changes_, changes) != changes;
    network_has_changed_ |= changed;
    return changed;
  }

  Result<std::unique_ptr<core::NetworkWriter>> open_writer(const core::WriterSpec& spec) override {
    if (spec.id == 0 || spec.type == nullptr)
      return fail(Errc::invalid_argument, "a writer needs an id and a type");
    return std::make_unique<UdpWriter>(spec, send_side_);
  }

  Result<std::unique_ptr<core::NetworkReader>> open_reader(const core::ReaderSpec& spec) override {
    if (spec.type == nullptr) return fail(Errc::invalid_argument, "a reader needs a type");
    return std::make_unique<UdpReader>(spec, receiver_);
  }

  Counters counters() const noexcept override {
    Counters counters = receiver_->counters();
    counters.over_limit += send_side_->over_limit.load(std::memory_order_relaxed);
    counters.malformed += send_side_->malformed_answers.load(std::memory_order_relaxed);
    counters.rejected += send_side_->answers_rejected.load(std::memory_order_relaxed);
    return counters;
  }

 private:
  const std::vector<NodeStatus::QuickPath> quick_paths_;  ///< its first entry is io_uring
  const std::string description_;
  const std::size_t max_sample_bytes_;
  const core::IpAddress bound_to_;
  const std::vector<core::IpAddress> advertised_;
  const std::vector<std::string> interfaces_;
  std::uint64_t network_changes_ = 0;  ///< number of network changes seen so far
  bool network_has_changed_ = false;
  std::vector<Remark> remarks_;  ///< remarks that have not been returned to the node yet
  mutable core::Mutex links_mutex_;
  /// The latest list of links. It is used while the system cannot list the links.
  mutable std::vector<core::Link> links_ SFT_GUARDED_BY(links_mutex_);
  std::chrono::steady_clock::time_point destinations_looked_after_at_{};
  const std::uint16_t port_;
  const int family_;  ///< family of the socket; a socket with AF_INET6 takes IPv4, too
  const std::uint32_t receive_buffer_bytes_;
  const std::shared_ptr<ReceiveLoop> receiver_;
  const std::shared_ptr<SendSide> send_side_;
};

Result<DatagramIo> open_io(Backend backend, const std::shared_ptr<const UdpSocket>& socket) {
  std::string why_no_io_uring = "the node asks for plain sockets";
  std::string remark;
  if (backend != Backend::sockets) {
    Result<DatagramIo> ring = open_uring_io(socket);
    if (ring || backend == Backend::io_uring) return ring;
    remark = " (" + ring.error().message + ")";
    why_no_io_uring = std::move(ring.error().message);
    if (why_no_io_uring.starts_with(no_io_uring)) why_no_io_uring.erase(0, no_io_uring.size());
  }
  Result<DatagramIo> plain = open_socket_io(socket);
  if (!plain) return plain;
  plain->description += remark;
  plain->why_no_io_uring = std::move(why_no_io_uring);
  return plain;
}

std::vector<NodeStatus::QuickPath> quick_paths(const DatagramIo& io, const UdpSocket& socket) {
  return {{"io_uring", io.why_no_io_uring},
          {"GSO", socket.why_no_gso},
          {"GRO", socket.why_no_gro},
          {"huge pages", core::why_no_huge_pages()}};
}

std::shared_ptr<SendSide> make_send_side(const UdpOptions& options, const UdpSocket& socket,
                                         std::unique_ptr<DatagramSender> io,
                                         std::shared_ptr<core::BufferPool> pool) {
  const std::uint16_t answer_port = io->answer_port() != 0 ? io->answer_port() : socket.port;
  const DestinationLimits limits{.datagram_bytes = options.max_datagram_bytes, .report_port = answer_port};
  auto side = std::make_shared<SendSide>(std::move(io), limits, options.max_bytes_per_s);
  side->max_sample_bytes = options.max_sample_bytes;
  side->queue_depth = options.send_queue_depth;
  side->answer_port = answer_port;
  side->multicast = options.multicast;
  side->kept = std::make_shared<KeptMemory>(pool->limit_bytes() / 2);
  side->pool = std::move(pool);
  return side;
}

std::shared_ptr<ReceiveLoop> make_receiver(const UdpOptions& options,
                                           const std::shared_ptr<const UdpSocket>& socket,
                                           std::shared_ptr<core::BufferPool> pool,
                                           std::unique_ptr<DatagramReceiver> io,
                                           const std::shared_ptr<SendSide>& send_side) {
  ReassemblyLimits limits = options.reassembly;
  limits.sample_bytes = options.max_sample_bytes;
  limits.channel.seed = std::random_device()();
  ReceiveLoop::SendingHalf half;
  half.hear_answer = [send_side](const Answer& answer, const SocketAddress& from,
                                 std::chrono::steady_clock::time_point now) {
    if (send_side->sender.answer_port() != 0) {  // answers must come to that port
      send_side->malformed_answers.fetch_add(1, std::memory_order_relaxed);
    } else {
      send_side->sender.wake(hear_answer(*send_side, answer, from, now));
    }
  };
  // Answers leave through the receiving socket, so that a sender that requests many of them uses up neither
  // descriptors nor memory. An answer that cannot be sent at once is dropped; a later one replaces it.
  static_assert(report_bytes <= datagram_bytes_min && group_report_bytes <= datagram_bytes_min);
  const auto send = [send_side](const SocketAddress& to, const auto& answer) {
    std::array<std::byte, datagram_bytes_min> bytes;
    encode(answer, bytes.data());
    send_side->sender.send_to(to, std::span(bytes).first(answer.bytes()));
  };
  half.send_ack = send;
  half.send_report = send;
  half.send_group_report = send;
  return std::make_shared<ReceiveLoop>(std::move(io), limits, socket->receive_buffer_bytes, std::move(pool),
                                       std::move(half), std::make_shared<GroupJoins>(socket));
}

}  // namespace

Result<std::unique_ptr<core::Network>> open_udp_transport(const UdpOptions& options,
                                                          std::shared_ptr<core::BufferPool> pool,
                                                          const DecorateIo& decorate) {
  const auto forward = [](Error& error) { return tl::unexpected<Error>(std::move(error)); };
  if (Result<void> sound = check_interfaces(options.interfaces); !sound) return forward(sound.error());
  Result<std::shared_ptr<const UdpSocket>> socket =
      open_udp_socket({.bind = {options.bind_address, options.port},
                       .receive_buffer_bytes = options.receive_buffer_bytes,
                       .send_buffer_bytes = options.send_buffer_bytes,
                       .hears_groups = options.multicast != Multicast::off});
  if (!socket) return forward(socket.error());
  Result<DatagramIo> io = open_io(options.backend, *socket);
  if (!io) return forward(io.error());
  if (decorate) *io = decorate(std::move(*io));

  std::vector<NodeStatus::QuickPath> paths = quick_paths(*io, **socket);
  const auto send_side = make_send_side(options, **socket, std::move(io->sender), pool);
  const auto receiver = make_receiver(options, *socket, std::move(pool), std::move(io->receiver), send_side);
  auto transport = std::make_unique<UdpTransport>(options, **socket, std::move(io->description),
                                                  std::move(paths), receiver, send_side);
  if (Result<void> started = receiver->start(options.receive_thread); !started)
    return forward(started.error());
  SendSide& side = *send_side;  // the reference stays valid, because only the sender of `side` calls `hear`
  const auto hear = [&side](std::span<const std::byte> answer, const SocketAddress& from,
                            std::chrono::steady_clock::time_point now) {
    return hear_answer(side, answer, from, now);
  };
  if (Result<void> started = side.sender.start(options.send_thread, hear); !started)
    return forward(started.error());
  return transport;
}

}  // namespace sft::udp
