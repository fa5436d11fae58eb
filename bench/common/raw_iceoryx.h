// iceoryx as its own examples use it, in sftd's memory, with the interface of transfer.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iceoryx_posh/popo/untyped_publisher.hpp>
#include <iceoryx_posh/popo/untyped_subscriber.hpp>
#include <iceoryx_posh/popo/wait_set.hpp>
#include <span>

namespace sft::bench {

struct RawIceoryxTopic {
  const char* name = "raw";
  /// True: a writer waits for readers that have so many messages to read. False: they lose the oldest.
  bool waits = false;
  std::uint32_t depth = 256;
};

/// REQUIRES: sftd runs, as it does after a contest has run SFT's side; the process has no other writer of
/// this topic.
class RawIceoryxWriter {
 public:
  /// `bytes` is the size of the messages, at least 16.
  explicit RawIceoryxWriter(std::uint32_t bytes, const RawIceoryxTopic& topic = {});

  /// True for at least one reader, since iceoryx does not say how many there are. Each reader knows its own
  /// state.
  bool serves(std::size_t) const { return publisher_.hasSubscribers(); }
  void prepare(std::uint64_t number);
  /// The message that prepare() has made. Its first eight bytes are the number.
  std::span<std::byte> message() const { return {static_cast<std::byte*>(chunk_), bytes_}; }
  void publish() { publisher_.publish(chunk_); }

 private:
  iox::popo::UntypedPublisher publisher_;
  const std::uint32_t bytes_;
  void* chunk_ = nullptr;
};

/// Sleeps in a WaitSet.
class RawIceoryxReader {
 public:
  explicit RawIceoryxReader(const RawIceoryxTopic& topic = {});

  void wait() { wait_set_.wait(); }
  std::uint64_t take();
  std::size_t writers() const;

 private:
  iox::popo::UntypedSubscriber subscriber_;
  iox::popo::WaitSet<> wait_set_;
};

}  // namespace sft::bench
