#include <sft/sft.h>
#include <algorithm>
#include <messages.hpp>
#include <span>
#include <vector>

#include "bench/common/contender.h"
#include "bench/common/contest.h"
#include "bench/common/node_options.h"

namespace sft::bench {

namespace {

using sft_bench::Bulk;
using sft_bench::Small;
using F = Bulk::Field;

Small message(const Topic&, const Small*) { return {}; }
Bulk message(const Topic& topic, const Bulk*) {
  Bulk bulk;
  bulk.data.resize(topic.bulk_bytes, 1);
  return bulk;
}

Reliability reliability(const Topic& topic) {
  return topic.reliable ? Reliability::reliable : Reliability::best_effort;
}

/// The publisher waits for a reader that does not keep up, as those of other contenders do.
PublisherOptions publisher_options(const Topic& topic) {
  return {.reliability = reliability(topic), .max_blocking = std::chrono::seconds(1)};
}

template <class T>
std::size_t served_by(const Publisher<T>& publisher) {
  const std::vector<PublisherStatus::Reader> readers = publisher.status().readers;
  return static_cast<std::size_t>(std::ranges::count_if(readers, &PublisherStatus::Reader::served));
}

template <class T>
class SftWriter : public Writer {
 public:
  SftWriter(Node& node, const Topic& topic)
      : publisher_(node.publisher<T>(topic.name, publisher_options(topic)).value()),
        message_(message(topic, static_cast<const T*>(nullptr))) {}

  std::size_t readers() const override { return served_by(publisher_); }
  void write(std::uint64_t number) override {
    message_.number = number;
    publisher_.publish(message_);
  }
  void write_together(std::uint64_t first, std::uint64_t count) override {
    together_.resize(count, message_);
    for (T& m : together_) m.number = first++;
    publisher_.publish(std::span<const T>(together_));
  }

 private:
  Publisher<T> publisher_;
  T message_;
  std::vector<T> together_;
};

/// Makes samples in the memory from which they are sent. Writes only the number each time, since in a driver
/// the device writes the rest.
class SftLoanWriter : public Writer {
 public:
  SftLoanWriter(Node& node, const Topic& topic)
      : publisher_(node.publisher<Bulk>(topic.name, publisher_options(topic)).value()),
        data_bytes_(topic.bulk_bytes) {}

  std::size_t readers() const override { return served_by(publisher_); }
  void write(std::uint64_t number) override {
    prototype_.number = number;
    auto loan = publisher_.loan_for_overwrite(prototype_, {.data = data_bytes_}).value();
    const auto data = loan->data();
    if (data.back() != written) std::ranges::fill(data, written);  // only the first time
    std::move(loan).publish();
  }

 private:
  static constexpr std::uint8_t written = 1;
  Publisher<Bulk> publisher_;
  Bulk prototype_;
  const std::uint32_t data_bytes_;
};

SubscriberOptions subscriber_options(const Topic& topic) {
  SubscriberOptions options{.reliability = reliability(topic), .depth = topic.depth};
  if (topic.spinning) options.spin = std::chrono::seconds(1);
  if (topic.sleeps_at_once) options.spin = std::chrono::nanoseconds(0);
  return options;
}

/// Reads what the program asks for, and returns the number.
template <class S>
std::uint64_t read(const S& sample) {
  if constexpr (requires { sample->data().back(); }) {
    if (const auto data = sample->data(); !data.empty()) keep(data.back());
  }
  if constexpr (requires { sample->stamp_ns(); }) keep(sample->stamp_ns());
  return sample->number();
}

/// Reads the fields `requirement` of messages of type T.
template <class T, Req<T> requirement = Req<T>(all<T>)>
class SftReader : public Reader {
 public:
  SftReader(Node& node, const Topic& topic, Arrived arrived)
      : subscriber_((arrived ? node.subscriber<T, requirement>(topic.name, tell(std::move(arrived)),
                                                               subscriber_options(topic))
                             : node.subscriber<T, requirement>(topic.name, subscriber_options(topic)))
                        .value()) {}

  std::size_t writers() const override {
    const std::vector<SubscriberStatus::Writer> writers = subscriber_.status().writers;
    return static_cast<std::size_t>(std::ranges::count_if(writers, &SubscriberStatus::Writer::connected));
  }
  void wait() override { subscriber_.wait(std::chrono::seconds(1)); }
  std::uint64_t take() override {
    const auto sample = subscriber_.take();
    return sample ? read(sample) : 0;
  }

 private:
  static auto tell(Arrived arrived) {
    return
        [arrived = std::move(arrived)](const Sample<T, requirement>& sample) { arrived(sample->number()); };
  }

  Subscriber<T, requirement> subscriber_;
};

class SftPeer : public Peer {
 public:
  struct Ways {
    TransportChoice transport = TransportChoice::udp;
    bool loans = false;
    std::size_t receive_buffer_bytes = UdpSettings{}.receive_buffer_bytes;
  };

  explicit SftPeer(const Ways& ways) : loans_(ways.loans), node_(open(ways)) {}

  std::unique_ptr<Writer> writer(const Topic& topic) override {
    if (loans_) return std::make_unique<SftLoanWriter>(node_, topic);
    if (topic.bulk_bytes > 0) return std::make_unique<SftWriter<Bulk>>(node_, topic);
    return std::make_unique<SftWriter<Small>>(node_, topic);
  }
  std::unique_ptr<Reader> reader(const Topic& topic, Arrived arrived) override {
    if (topic.bulk_bytes > 0 && topic.two_fields)
      return std::make_unique<SftReader<Bulk, F::number | F::stamp_ns>>(node_, topic, std::move(arrived));
    if (topic.bulk_bytes > 0) return std::make_unique<SftReader<Bulk>>(node_, topic, std::move(arrived));
    return std::make_unique<SftReader<Small>>(node_, topic, std::move(arrived));
  }

 private:
  static Node open(const Ways& ways) {
    NodeOptions options = node_options("bench", ways.transport);
    options.udp.receive_buffer_bytes = ways.receive_buffer_bytes;
    return Node::open(options).value();
  }

  const bool loans_;
  Node node_;
};

std::unique_ptr<Peer> peer(const SftPeer::Ways& ways) { return std::make_unique<SftPeer>(ways); }

}  // namespace

std::unique_ptr<Peer> sft_peer() { return peer({}); }
std::unique_ptr<Peer> sft_loan_peer() { return peer({.loans = true}); }
std::unique_ptr<Peer> sft_small_buffer_peer() { return peer({.receive_buffer_bytes = 4 << 20}); }
std::unique_ptr<Peer> sft_memory_peer() { return peer({.transport = TransportChoice::shm}); }
std::unique_ptr<Peer> sft_memory_loan_peer() {
  return peer({.transport = TransportChoice::shm, .loans = true});
}

}  // namespace sft::bench
