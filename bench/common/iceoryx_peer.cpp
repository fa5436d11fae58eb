// The contender iceoryx, in sftd's memory and used as in iceoryx's own examples.
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <iceoryx_hoofs/log/logmanager.hpp>
#include <iceoryx_posh/popo/untyped_publisher.hpp>
#include <iceoryx_posh/popo/untyped_subscriber.hpp>
#include <iceoryx_posh/popo/wait_set.hpp>
#include <iceoryx_posh/runtime/posh_runtime.hpp>
#include <string>
#include <vector>

#include "bench/common/contender.h"

namespace sft::bench {

namespace {

/// Joins sftd. Called before any port is made. sftd serves only programs whose names begin with "sft_".
iox::capro::ServiceDescription service(const Topic& topic) {
  iox::log::LogManager::GetLogManager().SetDefaultLogLevel(iox::log::LogLevel::kOff,
                                                           iox::log::LogLevelOutput::kHideLogLevel);
  iox::runtime::PoshRuntime::initRuntime(
      iox::RuntimeName_t(iox::cxx::TruncateToCapacity, "sft_raw_" + std::to_string(getpid())));
  return {"bench", "memory", iox::capro::IdString_t(iox::cxx::TruncateToCapacity, topic.name)};
}

iox::popo::PublisherOptions writer_options(const Topic& topic) {
  iox::popo::PublisherOptions options;
  if (topic.reliable) options.subscriberTooSlowPolicy = iox::popo::ConsumerTooSlowPolicy::WAIT_FOR_CONSUMER;
  return options;
}

iox::popo::SubscriberOptions reader_options(const Topic& topic) {
  iox::popo::SubscriberOptions options;
  options.queueCapacity = topic.depth;
  if (topic.reliable) options.queueFullPolicy = iox::popo::QueueFullPolicy::BLOCK_PRODUCER;
  return options;
}

class IceoryxWriter : public LendingWriter {
 public:
  IceoryxWriter(const Topic& topic, bool copies)
      : publisher_(service(topic), writer_options(topic)),
        bytes_(topic.bulk_bytes),
        data_(copies ? topic.bulk_bytes - sizeof(std::uint64_t) : 0, std::byte{1}),
        readers_(topic.readers) {}

  /// Returns the number of all readers or 0, because iceoryx does not report the number of connected
  /// readers. Each reader knows whether it is connected itself.
  std::size_t readers() const override { return publisher_.hasSubscribers() ? readers_ : 0; }
  void prepare(std::uint64_t number) override {
    publisher_.loan(bytes_).and_then([&](void* chunk) { chunk_ = chunk; }).or_else([](auto) {
      std::abort();
    });
    std::memcpy(chunk_, &number, sizeof number);
    std::ranges::copy(data_, static_cast<std::byte*>(chunk_) + sizeof number);
  }
  void publish() override { publisher_.publish(chunk_); }

 private:
  iox::popo::UntypedPublisher publisher_;
  const std::uint32_t bytes_;
  const std::vector<std::byte> data_;  ///< the data that is copied into each loan; empty if no data is copied
  const std::size_t readers_;
  void* chunk_ = nullptr;
};

/// A reader that sleeps in a WaitSet.
class IceoryxReader : public Reader {
 public:
  explicit IceoryxReader(const Topic& topic)
      : subscriber_(service(topic), reader_options(topic)), spinning_(topic.spinning) {
    wait_set_.attachState(subscriber_, iox::popo::SubscriberState::HAS_DATA).or_else([](auto) {
      std::abort();
    });
  }

  std::size_t writers() const override {
    return subscriber_.getSubscriptionState() == iox::SubscribeState::SUBSCRIBED ? 1 : 0;
  }
  void wait() override {
    if (!spinning_) wait_set_.wait();
  }
  std::uint64_t take() override {
    std::uint64_t number = 0;
    subscriber_.take().and_then([&](const void* chunk) {
      std::memcpy(&number, chunk, sizeof number);
      subscriber_.release(chunk);
    });
    return number;
  }

 private:
  iox::popo::UntypedSubscriber subscriber_;
  iox::popo::WaitSet<> wait_set_;
  const bool spinning_;  ///< true: the caller spins, and calls take() until a sample arrives
};

class IceoryxPeer : public Peer {
 public:
  explicit IceoryxPeer(bool copies) : copies_(copies) {}
  std::unique_ptr<Writer> writer(const Topic& topic) override {
    return std::make_unique<IceoryxWriter>(topic, copies_);
  }
  std::unique_ptr<Reader> reader(const Topic& topic, Arrived) override {
    return std::make_unique<IceoryxReader>(topic);
  }

 private:
  const bool copies_;
};

}  // namespace

std::unique_ptr<Peer> iceoryx_peer() { return std::make_unique<IceoryxPeer>(true); }
std::unique_ptr<Peer> iceoryx_loan_peer() { return std::make_unique<IceoryxPeer>(false); }

}  // namespace sft::bench
