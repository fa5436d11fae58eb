#include "udp_transport/io/train_reader.h"

#include <cerrno>
#include <span>
#include <utility>

namespace sft::udp {

TrainReader::TrainReader(std::shared_ptr<const UdpSocket> socket)
    : socket_(std::move(socket)), train_(train_bytes_max) {}

bool TrainReader::read(DatagramSink& sink) noexcept {
  if (!socket_->in_groups.load(std::memory_order_relaxed)) return read_from(socket_->fd.get(), sink);
  if (trains_in_a_row_ == trains_in_a_row_max) {
    trains_in_a_row_ = 0;
    if (read_from_groups(sink)) return true;
  }
  if (read_from(socket_->fd.get(), sink)) {
    ++trains_in_a_row_;
    return true;
  }
  trains_in_a_row_ = 0;
  return read_from_groups(sink);
}

bool TrainReader::read_from_groups(DatagramSink& sink) noexcept {
  const FileDescriptor& groups = socket_->groups.group_fd;
  return groups && read_from(groups.get(), sink);
}

bool TrainReader::read_from(int fd, DatagramSink& sink) noexcept {
  sockaddr_in6 from{};
  iovec whole{train_.data(), train_.size()};
  msghdr message{};
  message.msg_name = &from;
  message.msg_namelen = sizeof from;
  message.msg_iov = &whole;
  message.msg_iovlen = 1;
  message.msg_control = control_;
  message.msg_controllen = sizeof control_;
  const ssize_t bytes = ::recvmsg(fd, &message, MSG_DONTWAIT);
  // Other errors are about an earlier datagram, and the call has cleared them.
  if (bytes < 0) return errno != EAGAIN;
  if ((message.msg_flags & MSG_TRUNC) != 0) return true;
  hand_over(std::span(train_).first(static_cast<std::size_t>(bytes)),
            std::span(control_).first(message.msg_controllen), from, sink);
  return true;
}

}  // namespace sft::udp
