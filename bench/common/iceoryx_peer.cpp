#include <algorithm>
#include <vector>

#include "bench/common/contender.h"
#include "bench/common/raw_iceoryx.h"

namespace sft::bench {

namespace {

RawIceoryxTopic topic_of(const Topic& topic) {
  return {.name = topic.name, .waits = topic.reliable, .depth = topic.depth};
}

class IceoryxWriter : public Writer {
 public:
  IceoryxWriter(const Topic& topic, bool copies)
      : writer_(topic.bulk_bytes, topic_of(topic)),
        data_(copies ? topic.bulk_bytes - sizeof(std::uint64_t) : 0, std::byte{1}),
        readers_(topic.readers) {}

  std::size_t readers() const override { return writer_.serves(readers_) ? readers_ : 0; }
  void write(std::uint64_t number) override {
    writer_.prepare(number);
    std::ranges::copy(data_, writer_.message().begin() + sizeof number);
    writer_.publish();
  }

 private:
  RawIceoryxWriter writer_;
  const std::vector<std::byte> data_;  ///< what is copied into each loan; empty if nothing is
  const std::size_t readers_;
};

class IceoryxReader : public Reader {
 public:
  explicit IceoryxReader(const Topic& topic) : reader_(topic_of(topic)), spinning_(topic.spinning) {}

  std::size_t writers() const override { return reader_.writers(); }
  void wait() override {
    if (!spinning_) reader_.wait();
  }
  std::uint64_t take() override { return reader_.take(); }

 private:
  RawIceoryxReader reader_;
  const bool spinning_;  ///< the caller does, which calls take() until a sample comes
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
