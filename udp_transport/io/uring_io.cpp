#include "udp_transport/io/uring_io.h"

#include <liburing.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <fstream>
#include <string>
#include <system_error>
#include <utility>

#include "core/sync/spin.h"
#include "udp_transport/io/socket_io.h"
#include "udp_transport/io/socket_sender.h"

namespace sft::udp {

namespace {

using Clock = std::chrono::steady_clock;

__kernel_timespec until(Clock::time_point deadline) {
  using namespace std::chrono;
  const auto left = std::max(duration_cast<nanoseconds>(deadline - Clock::now()), nanoseconds{0});
  return {.tv_sec = left.count() / 1'000'000'000, .tv_nsec = left.count() % 1'000'000'000};
}

/// A ring that any thread may open. It then belongs to the first thread that calls enable().
class Ring {
 public:
  Ring() = default;
  Ring(const Ring&) = delete;
  Ring& operator=(const Ring&) = delete;
  ~Ring() { close(); }

  /// Opens the ring. Returns 0 or a positive errno.
  int open(unsigned entries, unsigned completions) noexcept {
    io_uring_params params{};
    params.flags = IORING_SETUP_R_DISABLED | IORING_SETUP_SINGLE_ISSUER | IORING_SETUP_DEFER_TASKRUN |
                   IORING_SETUP_TASKRUN_FLAG | IORING_SETUP_SUBMIT_ALL | IORING_SETUP_CQSIZE |
                   IORING_SETUP_CLAMP;
    params.cq_entries = completions;
    const int error = -io_uring_queue_init_params(entries, &ring_, &params);
    open_ = error == 0;
    return error;
  }

  /// Registers files; operations name a file by its position in `files`. Returns 0 or a positive errno.
  template <std::size_t n>
  int register_files(const std::array<int, n>& files) noexcept {
    return -io_uring_register_files(&ring_, files.data(), n);
  }

  /// Enables the ring for the calling thread. Returns 0 or a positive errno.
  int enable() noexcept {
    if (enabled_) return 0;
    // liburing 2.3 declares a function for this, but does not export it.
    const int result = io_uring_register(ring_.ring_fd, IORING_REGISTER_ENABLE_RINGS, nullptr, 0);
    enabled_ = result == 0;
    if (enabled_) io_uring_register_ring_fd(&ring_);  // this only saves time, so a refusal does not matter
    return -result;
  }
  bool enabled() const { return enabled_; }

  void close() noexcept {
    if (!open_) return;
    // The files are freed at once. The kernel frees the rest of the ring a little later.
    io_uring_unregister_files(&ring_);
    io_uring_queue_exit(&ring_);
    open_ = enabled_ = false;
  }

  io_uring_sqe* next_submission() noexcept {
    io_uring_sqe* submission = io_uring_get_sqe(&ring_);
    while (submission == nullptr) {
      io_uring_submit(&ring_);
      submission = io_uring_get_sqe(&ring_);
    }
    return submission;
  }

  /// Submits the operations, then waits for that number of completions or until the deadline. Returns 0, or
  /// the errno if the kernel refused the call.
  int wait(unsigned completions, Clock::time_point deadline) noexcept {
    int result = 0;
    if (deadline == Clock::time_point::max()) {
      result = io_uring_submit_and_wait(&ring_, completions);
    } else {
      __kernel_timespec timeout = until(deadline);
      io_uring_cqe* ignored = nullptr;
      result = io_uring_submit_and_wait_timeout(&ring_, &ignored, completions, &timeout, nullptr);
    }
    const bool waited =
        result >= 0 || result == -ETIME || result == -EINTR || result == -EAGAIN || result == -EBUSY;
    return waited ? 0 : -result;
  }

  /// Returns true if wait() would return at once. Makes no system call: the kernel makes completions only in
  /// wait(), but sets a flag as soon as a completion is pending.
  bool has_news() noexcept {
    return (IO_URING_READ_ONCE(*ring_.sq.kflags) & IORING_SQ_TASKRUN) != 0 || io_uring_cq_ready(&ring_) != 0;
  }
  bool has_submissions() noexcept { return io_uring_sq_ready(&ring_) != 0; }

  /// Calls `handle(completion)` for each completion. The slot of each completion is given back to the kernel
  /// before `handle` is called.
  template <class Handle>
  void for_each_completion(Handle&& handle) noexcept {
    io_uring_cqe* completion = nullptr;
    while (io_uring_peek_cqe(&ring_, &completion) == 0) {
      const io_uring_cqe copy = *completion;
      io_uring_cqe_seen(&ring_, completion);
      handle(copy);
    }
  }

  io_uring* get() { return &ring_; }

 private:
  io_uring ring_{};
  bool open_ = false;
  bool enabled_ = false;
};

/// Memory from the kernel. It is page-aligned, and only pages that receive datagrams are touched.
class Pages {
 public:
  Pages() = default;
  Pages(const Pages&) = delete;
  Pages& operator=(const Pages&) = delete;
  ~Pages() {
    if (data_ != nullptr) ::munmap(data_, bytes_);
  }
  bool map(std::size_t bytes) noexcept {
    void* mapped = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (mapped == MAP_FAILED) return false;
    data_ = static_cast<std::byte*>(mapped);
    bytes_ = bytes;
    return true;
  }
  std::byte* data() const { return data_; }

 private:
  std::byte* data_ = nullptr;
  std::size_t bytes_ = 0;
};

/// The buffers into which the kernel receives trains of datagrams. Each buffer holds one train and the data
/// of recvmsg() about that train.
class BufferRing {
 public:
  static constexpr unsigned buffers = 4;  // few, so that they stay in the nearest cache until they are read
  static constexpr std::size_t buffer_bytes = train_bytes_max + 256;
  static constexpr std::uint16_t group = 0;

  /// Registers the buffers with the ring. Returns 0 or a positive errno.
  int open(io_uring* ring) noexcept {
    if (!entries_.map(buffers * sizeof(io_uring_buf)) || !memory_.map(buffers * buffer_bytes)) return ENOMEM;
    io_uring_buf_reg registration{};
    registration.ring_addr = reinterpret_cast<std::uintptr_t>(entries_.data());
    registration.ring_entries = buffers;
    registration.bgid = group;
    if (const int error = -io_uring_register_buf_ring(ring, &registration, 0); error != 0) return error;
    io_uring_buf_ring_init(entries());
    for (unsigned id = 0; id < buffers; ++id) give_back(id);
    return 0;
  }

  std::byte* at(unsigned id) const { return memory_.data() + id * buffer_bytes; }

  void give_back(unsigned id) noexcept {
    io_uring_buf_ring_add(entries(), at(id), buffer_bytes, static_cast<unsigned short>(id),
                          io_uring_buf_ring_mask(buffers), 0);
    io_uring_buf_ring_advance(entries(), 1);
  }

 private:
  io_uring_buf_ring* entries() const { return reinterpret_cast<io_uring_buf_ring*>(entries_.data()); }
  Pages entries_;
  Pages memory_;
};

std::string why_forbidden() {
  // In this file, 1 means disabled for unprivileged processes, and 2 for all processes. Older kernels do not
  // have the file; `disabled` is then 0.
  int disabled = 0;
  std::ifstream("/proc/sys/kernel/io_uring_disabled") >> disabled;
  if (disabled == 0) return "it is forbidden here (a seccomp profile, as containers have)";
  return "it is forbidden here (sysctl kernel.io_uring_disabled is " + std::to_string(disabled) + ")";
}

std::string why_refused(int error) {
  switch (error) {
    case EPERM:
    case EACCES:
      return why_forbidden();
    case ENOSYS:
      return "the kernel has none";
    case EINVAL:
      return "the kernel is older than 6.1";
    case ENOMEM:
      return "too little memory may be locked (ulimit -l)";
    default:
      return std::system_category().message(error);
  }
}

class UringReceiver final : public DatagramReceiver {
 public:
  UringReceiver(std::shared_ptr<const UdpSocket> socket, FileDescriptor wake_event)
      : socket_(socket), plain_(std::move(socket), std::move(wake_event)) {
    layout_.msg_namelen = sender_address_bytes;
    layout_.msg_controllen = train_control_bytes;
  }

  int open() noexcept {
    if (const int error = ring_.open(8, 2 * BufferRing::buffers); error != 0) return error;
    if (const int error = register_files(); error != 0) return error;
    return buffers_.open(ring_.get());
  }

  bool receive(DatagramSink& sink, Time deadline, std::chrono::nanoseconds spin) noexcept override {
    if (refusal_.load(std::memory_order_relaxed) == 0) {
      const int error = receive_by_ring(sink, deadline, spin);
      if (error == 0) return true;
      // A lack of memory may be temporary. In all other cases the program, or its container, has forbidden
      // the call.
      if (error != ENOMEM) refusal_.store(error, std::memory_order_relaxed);
    }
    return plain_.receive(sink, deadline, spin);
  }

  void wake() noexcept override { plain_.wake(); }

  /// The ring's receives stay armed meanwhile. That is safe, because a ring takes nothing from the socket
  /// outside of wait().
  bool receive_now(DatagramSink& sink) noexcept override { return plain_.receive_now(sink); }
  bool receive_from_groups(DatagramSink& sink) noexcept override { return plain_.receive_from_groups(sink); }
  Descriptors descriptors() const noexcept override { return plain_.descriptors(); }

  std::string fell_back() const override {
    const int error = refusal_.load(std::memory_order_relaxed);
    if (error == EPERM || error == EACCES || error == ENOSYS)
      return "it was forbidden while it was in use (a seccomp filter of this program or of its container)";
    return error == 0 ? "" : std::system_category().message(error);
  }

  /// Cancels the armed receives first: closing an armed ring would keep the port in use for some time.
  void finish() noexcept override {
    if (ring_.enabled() && armed()) {
      io_uring_sqe* s = ring_.next_submission();
      io_uring_prep_cancel64(s, 0, IORING_ASYNC_CANCEL_ANY | IORING_ASYNC_CANCEL_ALL);
      s->user_data = 0;
      while (armed() && ring_.wait(1, Clock::time_point::max()) == 0) {
        ring_.for_each_completion([this](const io_uring_cqe& completion) { complete(completion, nullptr); });
      }
    }
    ring_.close();
  }

 private:
  /// The size of the part of a buffer that holds the sender's address, of either family. The data after it
  /// is aligned.
  static constexpr socklen_t sender_address_bytes = 32;
  static_assert(sender_address_bytes >= sizeof(sockaddr_in6) && sender_address_bytes % alignof(cmsghdr) == 0);

  // The positions of the registered files.
  static constexpr int socket_place = 0;
  static constexpr int wake_place = 1;
  static constexpr int group_place = 2;

  static constexpr std::uint64_t receive_tag = 1;
  static constexpr std::uint64_t wake_tag = 2;
  static constexpr std::uint64_t group_tag = 3;

  int register_files() noexcept {
    const int datagrams = socket_->fd.get(), wake = descriptors().wake;
    if (!socket_->groups.group_fd) return ring_.register_files(std::array{datagrams, wake});
    return ring_.register_files(std::array{datagrams, wake, socket_->groups.group_fd.get()});
  }

  /// Receives by the ring. Returns 0, or the errno if the kernel refused to receive.
  int receive_by_ring(DatagramSink& sink, Time deadline, std::chrono::nanoseconds spin) noexcept {
    if (const int error = ring_.enable(); error != 0) return error;
    arm();
    if (spin.count() > 0 && !ring_.has_submissions())
      core::spin(std::min(deadline, Clock::now() + spin), [this] { return ring_.has_news(); });
    if (const int error = ring_.wait(1, deadline); error != 0) return error;
    int refused = 0;
    ring_.for_each_completion([&](const io_uring_cqe& completion) {
      if (const int error = complete(completion, &sink); error != 0) refused = error;
    });
    return refused;
  }

  bool armed() const { return receive_armed_ || group_armed_ || wake_armed_; }

  /// Arms the receives that are not armed. A multishot receive ends if it finds no free buffer, and on
  /// errors. No datagram is lost meanwhile. The two sockets are armed first in turns, because the socket
  /// that is armed first may use all buffers at once.
  void arm() noexcept {
    const bool groups_first = std::exchange(groups_first_, !groups_first_);
    if (groups_first) arm_groups();
    if (!receive_armed_) arm_receive(socket_place, receive_tag, receive_armed_);
    arm_groups();
    if (!wake_armed_) {
      io_uring_sqe* s = ring_.next_submission();
      io_uring_prep_poll_add(s, wake_place, POLLIN);
      s->flags |= IOSQE_FIXED_FILE;
      s->user_data = wake_tag;
      wake_armed_ = true;
    }
  }

  void arm_groups() noexcept {
    if (!group_armed_ && socket_->groups.group_fd) arm_receive(group_place, group_tag, group_armed_);
  }

  void arm_receive(int place, std::uint64_t tag, bool& is_armed) noexcept {
    io_uring_sqe* s = ring_.next_submission();
    io_uring_prep_recvmsg_multishot(s, place, &layout_, 0);
    s->flags |= IOSQE_BUFFER_SELECT | IOSQE_FIXED_FILE;
    s->buf_group = BufferRing::group;
    s->user_data = tag;
    is_armed = true;
  }

  /// Hands the train to the sink; without a sink the train is discarded. Returns an errno if the kernel
  /// cannot receive by the ring any more; else 0.
  int complete(const io_uring_cqe& completion, DatagramSink* sink) noexcept {
    if (completion.user_data == wake_tag) {
      eventfd_t ignored = 0;
      ::eventfd_read(descriptors().wake, &ignored);
      wake_armed_ = false;
    }
    if (completion.user_data != receive_tag && completion.user_data != group_tag) return 0;
    if ((completion.flags & IORING_CQE_F_MORE) == 0)
      (completion.user_data == group_tag ? group_armed_ : receive_armed_) = false;
    // Other errors concern single datagrams (an ICMP message) or are temporary (no free buffer).
    const bool ends = completion.res == -EINVAL || completion.res == -EOPNOTSUPP || completion.res == -EBADF;
    const int error = ends ? -completion.res : 0;
    if ((completion.flags & IORING_CQE_F_BUFFER) == 0) return error;
    const unsigned id = completion.flags >> IORING_CQE_BUFFER_SHIFT;
    if (sink != nullptr) hand_over_buffer(buffers_.at(id), completion.res, *sink);
    buffers_.give_back(id);
    return error;
  }

  void hand_over_buffer(std::byte* buffer, int bytes, DatagramSink& sink) noexcept {
    io_uring_recvmsg_out* out = io_uring_recvmsg_validate(buffer, bytes, &layout_);
    if (out == nullptr || (out->flags & MSG_TRUNC) != 0) return;
    const auto* from = static_cast<const sockaddr_in6*>(io_uring_recvmsg_name(out));
    std::byte* control = static_cast<std::byte*>(io_uring_recvmsg_name(out)) + layout_.msg_namelen;
    const auto* train = static_cast<const std::byte*>(io_uring_recvmsg_payload(out, &layout_));
    hand_over({train, io_uring_recvmsg_payload_length(out, bytes, &layout_)},
              {control, std::min<std::size_t>(out->controllen, train_control_bytes)}, *from, sink);
  }

  const std::shared_ptr<const UdpSocket> socket_;
  SocketReceiver plain_;
  msghdr layout_{};  ///< determines the space for address and control data at the beginning of each buffer
  BufferRing buffers_;
  Ring ring_;  // declared after `buffers_`, so that it is closed first
  bool receive_armed_ = false;
  bool group_armed_ = false;
  bool wake_armed_ = false;
  bool groups_first_ = false;    ///< true if the socket for groups is armed first the next time
  std::atomic<int> refusal_{0};  ///< errno that made the ring unusable; 0: the ring is in use
};

tl::unexpected<Error> refused(int error) {
  const bool forbidden = error == EPERM || error == EACCES;
  return fail(forbidden ? Errc::no_permission : Errc::unavailable,
              std::string(no_io_uring) + why_refused(error));
}

}  // namespace

Result<DatagramIo> open_uring_io(std::shared_ptr<const UdpSocket> socket) {
  Result<FileDescriptor> wake_event = open_wake_event();
  if (!wake_event) return tl::unexpected<Error>(std::move(wake_event.error()));
  auto receiver = std::make_unique<UringReceiver>(socket, std::move(*wake_event));
  if (const int error = receiver->open(); error != 0) return refused(error);
  Result<std::unique_ptr<DatagramSender>> sender = open_socket_sender(socket);
  if (!sender) return tl::unexpected<Error>(std::move(sender.error()));
  DatagramIo io;
  io.description = socket->receives_trains ? "io_uring with GRO and GSO" : "io_uring with GSO";
  io.receiver = std::move(receiver);
  io.sender = std::move(*sender);
  return io;
}

}  // namespace sft::udp
