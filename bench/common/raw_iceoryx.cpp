#include "bench/common/raw_iceoryx.h"

#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <iceoryx_hoofs/log/logmanager.hpp>
#include <iceoryx_posh/runtime/posh_runtime.hpp>
#include <string>

namespace sft::bench {

namespace {

/// Joins sftd before it makes a port. sftd serves only programs whose names begin with "sft_".
iox::capro::ServiceDescription service(const RawIceoryxTopic& topic) {
  iox::log::LogManager::GetLogManager().SetDefaultLogLevel(iox::log::LogLevel::kOff,
                                                           iox::log::LogLevelOutput::kHideLogLevel);
  iox::runtime::PoshRuntime::initRuntime(
      iox::RuntimeName_t(iox::cxx::TruncateToCapacity, "sft_raw_" + std::to_string(getpid())));
  return {"bench", "memory", iox::capro::IdString_t(iox::cxx::TruncateToCapacity, topic.name)};
}

iox::popo::PublisherOptions writer_options(const RawIceoryxTopic& topic) {
  iox::popo::PublisherOptions options;
  if (topic.waits) options.subscriberTooSlowPolicy = iox::popo::ConsumerTooSlowPolicy::WAIT_FOR_CONSUMER;
  return options;
}

iox::popo::SubscriberOptions reader_options(const RawIceoryxTopic& topic) {
  iox::popo::SubscriberOptions options;
  options.queueCapacity = topic.depth;
  if (topic.waits) options.queueFullPolicy = iox::popo::QueueFullPolicy::BLOCK_PRODUCER;
  return options;
}

}  // namespace

RawIceoryxWriter::RawIceoryxWriter(std::uint32_t bytes, const RawIceoryxTopic& topic)
    : publisher_(service(topic), writer_options(topic)), bytes_(bytes) {}

void RawIceoryxWriter::prepare(std::uint64_t number) {
  publisher_.loan(bytes_).and_then([&](void* chunk) { chunk_ = chunk; }).or_else([](auto) { std::abort(); });
  std::memcpy(chunk_, &number, sizeof number);
}

RawIceoryxReader::RawIceoryxReader(const RawIceoryxTopic& topic)
    : subscriber_(service(topic), reader_options(topic)) {
  wait_set_.attachState(subscriber_, iox::popo::SubscriberState::HAS_DATA).or_else([](auto) {
    std::abort();
  });
}

std::uint64_t RawIceoryxReader::take() {
  std::uint64_t number = 0;
  subscriber_.take().and_then([&](const void* chunk) {
    std::memcpy(&number, chunk, sizeof number);
    subscriber_.release(chunk);
  });
  return number;
}

std::size_t RawIceoryxReader::writers() const {
  return subscriber_.getSubscriptionState() == iox::SubscribeState::SUBSCRIBED ? 1 : 0;
}

}  // namespace sft::bench
