// iceoryx as its own examples use it, in sftd's memory, with the interface of transfer.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iceoryx_posh/popo/untyped_publisher.hpp>
#include <iceoryx_posh/popo/untyped_subscriber.hpp>
#include <iceoryx_posh/popo/wait_set.hpp>

namespace sft::bench {

/// REQUIRES: sftd runs, as it does after a contest has run SFT's side; the process has no other writer of
/// this class.
class RawIceoryxWriter {
 public:
  /// `bytes` is the size of the messages, at least 16.
  explicit RawIceoryxWriter(std::uint32_t bytes);

  /// True for at least one reader, since iceoryx does not say how many there are. Each reader knows its own
  /// state.
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
