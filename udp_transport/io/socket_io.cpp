#include "udp_transport/io/socket_io.h"

#include <poll.h>
#include <sys/eventfd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <utility>

#include "core/sync/spin.h"
#include "udp_transport/io/socket_sender.h"
#include "udp_transport/io/train_reader.h"
#include "udp_transport/io/wake_event.h"

namespace sft::udp {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int trains_per_call = 64;  // then wake() and the deadline are looked at again

class SocketReceiver final : public DatagramReceiver {
 public:
  SocketReceiver(std::shared_ptr<const UdpSocket> socket, FileDescriptor wake_event)
      : socket_(socket), wake_event_(std::move(wake_event)), trains_(std::move(socket)) {}

  bool receive(DatagramSink& sink, Time deadline, std::chrono::nanoseconds spin) noexcept override {
    const auto over = [&] { return trains_.read(sink) || was_woken(); };
    if (spin.count() > 0 && core::spin(std::min(deadline, Clock::now() + spin), over))
      deadline = {};  // once around, for what else there is
    std::array<pollfd, 2> ready{{{.fd = socket_->readable(), .events = POLLIN, .revents = 0},
                                 {.fd = wake_event_.get(), .events = POLLIN, .revents = 0}}};
    if (!poll_until(ready, deadline)) return true;
    if (ready[1].revents != 0) {
      woken_.store(false, std::memory_order_relaxed);
      eventfd_t ignored = 0;
      ::eventfd_read(wake_event_.get(), &ignored);
    }
    for (int i = 0; ready[0].revents != 0 && i < trains_per_call && trains_.read(sink); ++i) {
    }
    return (ready[0].revents & POLLNVAL) == 0;
  }

  void wake() noexcept override {
    ::eventfd_write(wake_event_.get(), 1);
    woken_.store(true, std::memory_order_relaxed);
  }
  void finish() noexcept override {}
  bool receive_now(DatagramSink& sink) noexcept override { return trains_.read(sink); }
  bool receive_from_groups(DatagramSink& sink) noexcept override { return trains_.read_from_groups(sink); }
  Descriptors descriptors() const noexcept override { return {socket_->readable(), wake_event_.get()}; }

 private:
  /// Takes the flag back. wake() may set it after its event was read: a flag that stayed would end each spin
  /// from then on.
  bool was_woken() noexcept {
    return woken_.load(std::memory_order_relaxed) && woken_.exchange(false, std::memory_order_relaxed);
  }

  const std::shared_ptr<const UdpSocket> socket_;
  const FileDescriptor wake_event_;
  TrainReader trains_;
  std::atomic<bool> woken_{false};  ///< for a loop that is busy
};

}  // namespace

Result<DatagramIo> open_socket_io(std::shared_ptr<const UdpSocket> socket) {
  Result<FileDescriptor> wake_event = open_wake_event();
  if (!wake_event) return tl::unexpected<Error>(std::move(wake_event.error()));
  Result<std::unique_ptr<DatagramSender>> sender = open_socket_sender(socket);
  if (!sender) return tl::unexpected<Error>(std::move(sender.error()));
  DatagramIo io;
  io.description = socket->receives_trains ? "plain sockets with GRO and GSO" : "plain sockets with GSO";
  io.receiver = std::make_unique<SocketReceiver>(std::move(socket), std::move(*wake_event));
  io.sender = std::move(*sender);
  return io;
}

}  // namespace sft::udp
