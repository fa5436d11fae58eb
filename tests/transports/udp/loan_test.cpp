// Only the message of a loan leaves the host. No bytes of earlier samples in the recycled memory do.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <vector>
#include <views.hpp>

#include "core/publish/publisher_core.h"
#include "sft/publisher.h"
#include "tests/support/encoded.h"
#include "tests/support/parse_datagram.h"
#include "tests/unit/core/seam/idle_ports.h"
#include "udp_transport/udp_transport.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {
namespace {

using namespace detail;

using views::Recording;
using F = Recording::Field;

constexpr std::uint8_t canary = 0xA5;

/// Assembles the bodies of samples from raw datagrams, and keeps the datagrams.
class Wire {
 public:
  Wire() {
    sockaddr_in any{};
    any.sin_family = AF_INET;
    any.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::bind(fd_, reinterpret_cast<sockaddr*>(&any), sizeof any), 0);
    const timeval hang_timeout{.tv_sec = 20, .tv_usec = 0};
    ::setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &hang_timeout, sizeof hang_timeout);
  }
  ~Wire() { ::close(fd_); }
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;

  core::UdpAddress address() const {
    sockaddr_in own{};
    socklen_t bytes = sizeof own;
    ::getsockname(fd_, reinterpret_cast<sockaddr*>(&own), &bytes);
    return {INADDR_LOOPBACK, ntohs(own.sin_port), 200'000};
  }

  std::vector<std::byte> next_body() {
    std::vector<std::byte> body(1);
    for (std::size_t received = 0; received < body.size();) {
      std::vector<std::byte> bytes(datagram_bytes_max);
      ssize_t n = 0;
      sockaddr_in from{};
      do {
        socklen_t from_bytes = sizeof from;
        n = ::recvfrom(fd_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&from), &from_bytes);
        // Because of the socket's time-out, the kernel does not restart an interrupted call.
      } while (n < 0 && errno == EINTR);
      if (n <= 0) return {};
      bytes.resize(static_cast<std::size_t>(n));
      if (const auto mark = parse_as<FlowMark>(bytes)) {
        report_on(*mark, from);
        continue;
      }
      const auto datagram = parse(bytes);
      if (!datagram) return {};
      if (datagram->kind == DatagramKind::first) {
        body.resize(datagram->first.total);
        sequence_ = datagram->first.label.sequence;
      }
      std::ranges::copy(datagram->payload, body.begin() + datagram->offset);
      received += datagram->payload.size();
      datagrams_.push_back(std::move(bytes));
    }
    return body;
  }
  std::uint32_t sequence() const { return sequence_; }  ///< the sequence of the last body

  /// Returns true if a datagram since the last call contains four canary bytes in a row. Ids and stamps may
  /// contain single canary bytes by chance.
  bool had_canaries() {
    const bool had = std::ranges::any_of(datagrams_, [](const std::vector<std::byte>& datagram) {
      return !std::ranges::search_n(datagram, 4, std::byte{canary}).empty();
    });
    datagrams_.clear();
    return had;
  }

 private:
  /// Sends a report. Without reports the publisher sends no large samples.
  void report_on(const FlowMark& mark, sockaddr_in to) {
    std::array<std::byte, report_bytes> report{};
    encode(FlowReport{.flow = mark.flow,
                      .position = mark.position,
                      .window_bytes = 150'000,
                      .datagrams = mark.datagrams,
                      .came = mark.datagrams,
                      .sent_at_ns = mark.sent_at_ns},
           report.data());
    to.sin_port = htons(mark.port);
    ::sendto(fd_, report.data(), report.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }

  int fd_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  std::vector<std::vector<std::byte>> datagrams_;
  std::uint32_t sequence_ = 0;
};

/// Shared memory with a reader that overwrites the samples that it gets.
class ScribbledOn final : public core::IdleLendingWriter {
 public:
  core::SampleHandle loan(std::size_t bytes) noexcept override { return pool_->take(bytes); }
  core::SendStatus send(const core::SampleHandle& sample) noexcept override {
    sample->header().body_offset += 8;
    sample->header().body_bytes = 0xFFFF'FFFF;
    sample->header().sequence = 4711;
    return core::SendStatus::sent;
  }

 private:
  std::shared_ptr<core::BufferPool> pool_ = core::BufferPool::make(1 << 20);
};

class LoansOnTheWire : public ::testing::TestWithParam<Backend> {
 protected:
  LoansOnTheWire() {
    core::Serving serving;
    serving.network = {{2, wire.address(), type.full()}};
    core->serve(serving, nullptr);
  }

  /// Publishes a sample full of canary bytes, in memory that the next samples will get.
  void send_canaries() {
    Recording message;
    message.left.label.assign(50, static_cast<char>(canary));
    message.cloud.fields.resize(3);
    auto loan = publisher.loan_for_overwrite(message, {.stamps = 50, .cloud = {.data = 30'000}}).value();
    std::ranges::fill(loan->stamps(), -0x5A5A'5A5A'5A5A'5A5B);
    std::ranges::fill(loan->cloud().data(), canary);
    EXPECT_EQ(std::move(loan).publish(), PublishStatus::ok);
    wire.next_body();
    EXPECT_TRUE(wire.had_canaries());
  }

  const TypeSupport& type = type_support<Recording>();
  std::shared_ptr<core::BufferPool> pool = core::BufferPool::make(1 << 20);
  std::unique_ptr<core::Network> transport =
      open_udp_transport({.bind_address = INADDR_LOOPBACK, .backend = GetParam()}, pool).value();
  std::shared_ptr<core::PublisherCore> core =
      std::make_shared<core::PublisherCore>(core::PublisherCore::Spec{7, "topic", &type, 1 << 20}, pool,
                                            transport->open_writer({7, &type}).value());
  Publisher<Recording> publisher{untyped::Publisher(core)};
  Wire wire;
};

TEST_P(LoansOnTheWire, CarryNothingOfEarlierSamples) {
  for (int round = 0; round < 10; ++round) {
    send_canaries();
    auto loan = publisher.loan({}, {.stamps = 40, .left = {.ranges = 9}, .cloud = {.data = 31'000}}).value();
    std::ranges::fill(loan->cloud().data().first(10'000), std::uint8_t{1});
    loan.shrink(F::cloud.data, 29'999);
    loan.shrink(F::stamps, 3);
    loan.shrink(F::left.ranges, 8);
    EXPECT_EQ(std::move(loan).publish(), PublishStatus::ok);

    Recording expected;
    expected.stamps.resize(3);
    expected.left.ranges.resize(8);
    expected.cloud.data.assign(10'000, 1);
    expected.cloud.data.resize(29'999);
    EXPECT_EQ(wire.next_body(), sft::test::Encoded(expected).bytes());
    EXPECT_FALSE(wire.had_canaries());
  }
}

TEST_P(LoansOnTheWire, AreSentAsTheyWereWhateverLocalReadersWriteIntoThem) {
  core::Serving serving;
  serving.network = {{2, wire.address(), type.full()}};
  serving.memory = {{3, core::DoorbellAddress{}, type.full()}};
  core->serve(serving, std::make_shared<ScribbledOn>());
  Recording message;
  message.cloud.data.assign(3000, 7);
  const std::vector<std::byte> expected = sft::test::Encoded(message).bytes();
  EXPECT_EQ(publisher.publish(message), PublishStatus::ok);
  std::vector<std::byte> body = wire.next_body();
  ASSERT_GE(body.size(), expected.size());
  EXPECT_LE(body.size(), std::bit_ceil(expected.size() + sizeof(SampleHeader))) << "more than the buffer";
  body.resize(expected.size());
  EXPECT_EQ(body, expected);
  EXPECT_EQ(wire.sequence(), 1U);
}

INSTANTIATE_TEST_SUITE_P(Backends, LoansOnTheWire, ::testing::Values(Backend::automatic, Backend::sockets),
                         [](const auto& test) {
                           return test.param == Backend::sockets ? "sockets" : "automatic";
                         });

}  // namespace
}  // namespace sft::udp
