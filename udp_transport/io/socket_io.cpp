#include "udp_transport/io/socket_io.h"

#include <utility>

#include "udp_transport/io/socket_receiver.h"
#include "udp_transport/io/socket_sender.h"
#include "udp_transport/io/wake_event.h"

namespace sft::udp {

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
