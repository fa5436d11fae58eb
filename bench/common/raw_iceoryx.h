// iceoryx as its own examples use it, on sftd's memory, in the words of transfer.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iceoryx_posh/popo/untyped_publisher.hpp>
#include <iceoryx_posh/popo/untyped_subscriber.hpp>
#include <iceoryx_posh/popo/wait_set.hpp>

namespace sft::bench {

/// REQUIRES: sftd runs, which what begins with our own side has seen to; one of these in a process.
class RawIceoryxWriter {
 public:
  /// `bytes` is the size of its messages, at least 16.
  explicit RawIceoryxWriter(std::uint32_t bytes);

  /// At least one: iceoryx does not say how many, but each reader knows its part.
  bool serves(std::size_t) const { return publisher_.hasSubscribers(); }
  void prepare(std::uint64_t number);
  void publish() { publisher_.publish(chunk_); }

 private:
  iox::popo::UntypedPublisher publisher_;
  const std::uint32_t bytes_;
  void* chunk_ = nullptr;
};

/// Sleeps in a WaitSet.
class RawIceoryxReader {
 public:
  RawIceoryxReader();

  void wait() { wait_set_.wait(); }
  std::uint64_t take();
  std::size_t writers() const;

 private:
  iox::popo::UntypedSubscriber subscriber_;
  iox::popo::WaitSet<> wait_set_;
};

}  // namespace sft::bench
