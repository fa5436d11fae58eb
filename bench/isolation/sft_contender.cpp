// SFT with its default settings: shared memory within the host, UDP to the other one.
#include <sft/sft.h>
#include <algorithm>
#include <utility>
#include <vector>

#include "bench/common/cloud.h"
#include "bench/isolation/contender.h"

namespace sft::bench::isolation {

namespace {

using sensor_msgs::msg::PointCloud2;

Reliability reliability(bool reliable) { return reliable ? Reliability::reliable : Reliability::best_effort; }

/// The hosts have a network of their own each, and one memory together, in which the remote reader must not
/// look for samples.
Node open(const char* name, Place place) {
  const auto transport = place == Place::local ? TransportChoice::automatic : TransportChoice::udp;
  return Node::open({.name = name, .transport = transport}).value();
}

class SftWriter : public Writer {
 public:
  explicit SftWriter(bool reliable) : node_(open("sensors", Place::local)) {
    for (const char* topic : topics) {
      publishers_.push_back(
          node_.publisher<PointCloud2>(topic, {.reliability = reliability(reliable)}).value());
    }
  }

  bool serves(std::size_t readers) const override {
    return std::ranges::all_of(publishers_, [&](const auto& publisher) {
      return publisher.wait_for_subscribers(readers, std::chrono::nanoseconds(0));
    });
  }
  void write(std::uint64_t number) override {
    cloud_.width = static_cast<std::uint32_t>(number);
    publishers_[number % topics.size()].publish(cloud_);
  }

 private:
  Node node_;
  std::vector<Publisher<PointCloud2>> publishers_;
  PointCloud2 cloud_ = cloud(sent_cloud_bytes);
};

class SftReader : public Reader {
 public:
  SftReader(bool reliable, Place place, const Arrived& arrived) : node_(open("reader", place)) {
    const SubscriberOptions options{.reliability = reliability(reliable), .depth = depth};
    for (const char* topic : topics) {
      auto callback = [arrived](const Sample<PointCloud2>& sample) {
        if (sample->data().size() == sent_cloud_bytes) arrived(sample->width());
      };
      subscribers_.push_back(node_.subscriber<PointCloud2>(topic, std::move(callback), options).value());
    }
  }

  bool is_matched() const override {
    return std::ranges::all_of(subscribers_, [](const auto& subscriber) {
      return std::ranges::any_of(subscriber.status().writers, &SubscriberStatus::Writer::connected);
    });
  }

 private:
  Node node_;
  std::vector<Subscriber<PointCloud2>> subscribers_;
};

}  // namespace

std::unique_ptr<Writer> open_sft_writer(bool reliable) { return std::make_unique<SftWriter>(reliable); }

std::unique_ptr<Reader> open_sft_reader(bool reliable, Place place, Arrived arrived) {
  return std::make_unique<SftReader>(reliable, place, arrived);
}

}  // namespace sft::bench::isolation
