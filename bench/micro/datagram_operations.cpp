#include <chrono>
#include <cstdlib>
#include <memory>
#include <utility>
#include <variant>

#include "bench/micro/operation.h"
#include "bench/typesupport/messages.h"
#include "sft/type_support.h"
#include "tests/unit/udp/datagrams.h"
#include "udp_transport/receive/reassembly.h"

namespace sft::bench::micro {

namespace {

using sensor_msgs::msg::PointCloud2;

constexpr std::size_t medium_bytes = 16'000;
constexpr std::size_t datagram_bytes = 1472;  // the payload of a datagram at an MTU of 1500
constexpr core::EndpointId writer = 1;

/// An encoded cloud, in the form in which a publisher passes it to the transport.
struct Encoded {
  explicit Encoded(std::size_t data_bytes) : sample(cloud(data_bytes)) {
    const auto body = sample.body().first(sample.state().body_bytes);
    run = {body.data(), body.size()};
    first.label.writer = static_cast<std::uint32_t>(writer);
    first.total = static_cast<std::uint32_t>(body.size());
    first.mask = FieldMask(all<PointCloud2>).hash();
  }
  udp::EncodedBody body() const { return {first, {}, {&run, 1}}; }

  Sample sample;
  detail::Segment run{};
  udp::FirstHeader first{};
};

Operation fragmenting(const std::string& name, std::size_t data_bytes) {
  struct State : Encoded {
    using Encoded::Encoded;
    udp::Batch batch;
  };
  const auto state = std::make_shared<State>(data_bytes);
  return {"fragment_" + name, state->run.bytes, batch_of([state] {
            udp::Fragmenter fragmenter(state->body(), datagram_bytes);
            while (!fragmenter.done()) fragmenter.next(state->batch);
            keep(state->batch.bytes());
          })};
}

/// Receives the datagrams of one sample repeatedly, each time as those of the next sample.
class Receiver {
 public:
  explicit Receiver(std::size_t data_bytes)
      : datagrams_(udp::test::cut(Encoded(data_bytes).body(), datagram_bytes)) {
    const udp::Stream stream{.writer = writer, .type = &type_, .selections = {FieldMask(all<PointCloud2>)}};
    reassembly_.set_streams({&stream, 1});
    receive();
    receive();
    if (came_ != 2) std::abort();
  }

  void receive() {
    ++sequence_;
    now_.steady += std::chrono::milliseconds(1);
    for (const auto& bytes : datagrams_) {
      udp::AnyDatagram any = udp::decode(bytes);
      const udp::Envelope envelope{from_, now_, bytes.size()};
      if (auto* following = std::get_if<udp::Following>(&any)) {
        following->label.sequence = sequence_;
        take(reassembly_.accept(*following, envelope));
      } else if (auto* first = std::get_if<udp::Datagram>(&any)) {
        first->first.label.sequence = sequence_;
        take(reassembly_.accept(*first, envelope));
      }
    }
  }

 private:
  void take(udp::Arrival arrival) {
    if (arrival.sample) ++came_;
  }

  const std::vector<udp::test::Bytes> datagrams_;
  const TypeSupport type_{detail::TypeTable<PointCloud2>::type};
  udp::Reassembly reassembly_{{}, core::BufferPool::make(std::size_t{64} << 20)};
  const udp::SocketAddress from_{};
  udp::ArrivalTime now_{udp::Reassembly::Time{} + std::chrono::hours(1), 1};
  std::uint32_t sequence_ = 0;
  std::size_t came_ = 0;
};

Operation reassembling(const std::string& name, std::size_t data_bytes) {
  const auto receiver = std::make_shared<Receiver>(data_bytes);
  return {"reassemble_" + name, Encoded(data_bytes).run.bytes, batch_of([receiver] { receiver->receive(); })};
}

}  // namespace

Operations fragment_operations() {
  return {fragmenting("16kB", medium_bytes), fragmenting("1.66MB", large_bytes)};
}

Operations reassemble_operations() {
  return {reassembling("16kB", medium_bytes), reassembling("1.66MB", large_bytes)};
}

}  // namespace sft::bench::micro
