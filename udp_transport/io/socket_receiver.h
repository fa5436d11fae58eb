// Receives datagrams through plain socket calls.
#pragma once

#include <atomic>
#include <memory>

#include "udp_transport/io/datagram_io.h"
#include "udp_transport/io/train_reader.h"
#include "udp_transport/io/udp_socket.h"

namespace sft::udp {

class SocketReceiver final : public DatagramReceiver {
 public:
  /// `wake_event` is an eventfd that does not block.
  SocketReceiver(std::shared_ptr<const UdpSocket> socket, FileDescriptor wake_event);

  bool receive(DatagramSink& sink, Time deadline, std::chrono::nanoseconds spin) noexcept override;
  void wake() noexcept override;
  void finish() noexcept override {}
  bool receive_now(DatagramSink& sink) noexcept override { return trains_.read(sink); }
  bool receive_from_groups(DatagramSink& sink) noexcept override { return trains_.read_from_groups(sink); }
  Descriptors descriptors() const noexcept override { return {socket_->readable(), wake_event_.get()}; }

 private:
  bool was_woken() noexcept;

  const std::shared_ptr<const UdpSocket> socket_;
  const FileDescriptor wake_event_;
  TrainReader trains_;
  std::atomic<bool> woken_{false};  ///< set by wake(), and read by a thread that spins
};

}  // namespace sft::udp
