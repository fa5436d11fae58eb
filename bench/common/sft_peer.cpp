#include <sft/sft.h>
#include <algorithm>
#include <messages.hpp>
#include <utility>
#include <vector>

#include "bench/common/cloud.h"
#include "bench/common/message_set.h"
#include "bench/common/node_options.h"
#include "bench/common/sft_endpoints.h"
#include "sft/detail/type_description.h"

namespace sft::bench {

namespace {

using sensor_msgs::msg::PointCloud2;
using sft_bench::Bulk;
using sft_bench::Small;
using F = Bulk::Field;
using CloudField = PointCloud2::Field;

struct Ways {
  TransportChoice transport = TransportChoice::udp;
  bool loans = false;
  bool clouds = false;  ///< true: bulk samples are point clouds in loans
  bool usual = false;   ///< true: the contender has its default settings
  bool multicast = true;
};

Bulk bulk(const Topic& topic) {
  Bulk bulk;
  bulk.data.resize(topic.bulk_bytes, 1);
  return bulk;
}

Reliability reliability(const Topic& topic) {
  return topic.reliable ? Reliability::reliable : Reliability::best_effort;
}

Durability durability(const Topic& topic) {
  return topic.durable ? Durability::transient_local : Durability::volatile_;
}

/// Returns the options of a publisher. Unless it has default settings, the publisher waits for slow
/// readers, like the writers of other contenders.
PublisherOptions publisher_options(const Topic& topic, const Ways& ways) {
  PublisherOptions options{.reliability = reliability(topic), .durability = durability(topic)};
  if (!ways.usual && topic.reliable) options.max_blocking = std::chrono::seconds(1);
  if (topic.messages)
    options.max_sample_bytes = std::max(options.max_sample_bytes, topic.messages->largest());
  return options;
}

SubscriberOptions subscriber_options(const Topic& topic) {
  SubscriberOptions options{
      .reliability = reliability(topic), .durability = durability(topic), .depth = topic.depth};
  if (topic.spinning) options.spin = std::chrono::seconds(1);
  if (topic.spin) options.spin = *topic.spin;
  return options;
}

/// Makes samples in the memory from which they are sent. Writes only the number each time, because in a
/// real driver the device would write the data.
class SftLoanWriter : public LendingWriter {
 public:
  SftLoanWriter(Node& node, const Topic& topic, const PublisherOptions& options)
      : publisher_(node.publisher<Bulk>(topic.name, options).value()), data_bytes_(topic.bulk_bytes) {}

  std::size_t readers() const override { return served_by(publisher_); }
  void prepare(std::uint64_t number) override {
    prototype_.number = number;
    loan_ = publisher_.loan_for_overwrite(prototype_, {.data = data_bytes_}).value();
    const auto data = (*loan_)->data();
    if (data.back() != written) std::ranges::fill(data, written);  // done once for each piece of memory
  }
  void publish() override { std::move(*loan_).publish(); }

 private:
  static constexpr std::uint8_t written = 1;
  Publisher<Bulk> publisher_;
  Bulk prototype_;
  const std::uint32_t data_bytes_;
  std::optional<Loan<Bulk>> loan_;
};

/// A writer that publishes clouds in loans. It does not write the data of the clouds.
class CloudLoanWriter : public LendingWriter {
 public:
  CloudLoanWriter(Node& node, const Topic& topic)
      : publisher_(node.publisher<PointCloud2>(topic.name).value()), data_bytes_(topic.bulk_bytes) {}

  std::size_t readers() const override { return served_by(publisher_); }
  void prepare(std::uint64_t number) override {
    loan_ = publisher_.loan_for_overwrite(prototype_, {.data = data_bytes_}).value();
    loan_->set(CloudField::width, static_cast<std::uint32_t>(number));
  }
  void publish() override { std::move(*loan_).publish(); }

 private:
  Publisher<PointCloud2> publisher_;
  const PointCloud2 prototype_ = cloud(0);
  const std::uint32_t data_bytes_;
  std::optional<Loan<PointCloud2>> loan_;
};

/// A reader that reads the height and width of a cloud. The number of points is the number of the sample.
class CloudReader : public Reader {
 public:
  CloudReader(Node& node, const Topic& topic)
      : subscriber_(
            node.subscriber<PointCloud2, CloudField::height | CloudField::width>(topic.name).value()) {}

  std::size_t writers() const override { return connected_to(subscriber_.status()); }
  void wait() override { subscriber_.wait(std::chrono::seconds(1)); }
  std::uint64_t take() override {
    const auto sample = subscriber_.take();
    return sample ? std::uint64_t{sample->height()} * sample->width() : 0;
  }

 private:
  Subscriber<PointCloud2, CloudField::height | CloudField::width> subscriber_;
};

/// Calls the getters of all leaves in a part of a sample.
void read_all(const DynamicView& part) {
  if (part.is_struct()) {
    for (const DynamicView& member : part.members()) read_all(member);
  } else if (part.is_collection() && part.type() != nullptr) {
    for (const DynamicView& element : part.elements()) read_all(element);
  } else {
    (void)static_cast<bool>(part);
  }
}

void read_fields(const DynamicSample& sample, FieldSet fields) {
  if (fields == 0) return;
  for (const DynamicView& member : sample.view().members()) {
    if ((fields & 1) != 0) read_all(member);
    fields >>= 1;
  }
}

/// A reader that reads the wanted fields of messages.
class SftFieldReader : public Reader {
 public:
  SftFieldReader(Node& node, const Topic& topic, Arrived arrived) {
    auto callback = [read = topic.wanted.read, arrived = std::move(arrived)](const DynamicSample& sample) {
      read_fields(sample, read);
      arrived(0);
    };
    const DynamicType type = DynamicType::parse(detail::describe(topic.messages->type().type())).value();
    const SubscriberOptions options = subscriber_options(topic);
    subscriber_ =
        (topic.wanted.recorded ? node.subscriber(topic.name, type, recorded, options, std::move(callback))
                               : node.subscriber(topic.name, type, topic.wanted.fields.value_or("*"), options,
                                                 std::move(callback)))
            .value();
  }

  std::size_t writers() const override { return connected_to(subscriber_->status()); }

 private:
  std::optional<DynamicSubscriber> subscriber_;
};

class SftPeer : public Peer {
 public:
  explicit SftPeer(const Ways& ways) : ways_(ways), node_(open(ways)) {}

  std::unique_ptr<Writer> writer(const Topic& topic) override {
    const PublisherOptions options = publisher_options(topic, ways_);
    if (topic.messages) return topic.messages->writer(node_, topic.name, options);
    if (ways_.clouds) return std::make_unique<CloudLoanWriter>(node_, topic);
    if (ways_.loans) return std::make_unique<SftLoanWriter>(node_, topic, options);
    if (topic.bulk_bytes > 0)
      return std::make_unique<SftWriter<Bulk>>(node_, topic.name, options, std::vector{bulk(topic)});
    return std::make_unique<SftWriter<Small>>(node_, topic.name, options, std::vector<Small>(1));
  }
  std::unique_ptr<Reader> reader(const Topic& topic, Arrived arrived) override {
    const SubscriberOptions options = subscriber_options(topic);
    if (topic.messages && !topic.wanted.fields && !topic.wanted.recorded)
      return topic.messages->reader(node_, topic.name, options, std::move(arrived));
    if (topic.messages) return std::make_unique<SftFieldReader>(node_, topic, std::move(arrived));
    if (ways_.clouds) return std::make_unique<CloudReader>(node_, topic);
    if (topic.bulk_bytes > 0 && topic.two_fields)
      return std::make_unique<SftReader<Bulk, F::number | F::stamp_ns>>(node_, topic.name, options,
                                                                        std::move(arrived));
    if (topic.bulk_bytes > 0)
      return std::make_unique<SftReader<Bulk>>(node_, topic.name, options, std::move(arrived));
    return std::make_unique<SftReader<Small>>(node_, topic.name, options, std::move(arrived));
  }
  void know_writer(const Topic& topic) override {
    // Long enough for the discovery of many nodes that start at once.
    constexpr std::chrono::seconds timeout{60};
    (void)node_.find_type(topic.name, timeout).value();
  }

 private:
  static Node open(const Ways& ways) {
    NodeOptions options = node_options("bench", ways.transport);
    if (ways.usual) options = {.name = "bench", .transport = ways.transport};
    if (!ways.multicast) options.udp.multicast = UdpSettings::Multicast::off;
    return Node::open(options).value();
  }

  const Ways ways_;
  Node node_;
};

std::unique_ptr<Peer> peer(const Ways& ways) { return std::make_unique<SftPeer>(ways); }

}  // namespace

std::unique_ptr<Peer> sft_peer() { return peer({}); }
std::unique_ptr<Peer> sft_loan_peer() { return peer({.loans = true}); }
std::unique_ptr<Peer> sft_usual_peer() { return peer({.usual = true}); }
std::unique_ptr<Peer> sft_unicast_peer() { return peer({.usual = true, .multicast = false}); }
std::unique_ptr<Peer> sft_local_peer() {
  return peer({.transport = TransportChoice::automatic, .usual = true});
}
std::unique_ptr<Peer> sft_memory_peer() { return peer({.transport = TransportChoice::shm}); }
std::unique_ptr<Peer> sft_memory_loan_peer() {
  return peer({.transport = TransportChoice::shm, .loans = true});
}
std::unique_ptr<Peer> sft_cloud_loan_peer() {
  return peer({.transport = TransportChoice::shm, .clouds = true});
}

}  // namespace sft::bench
