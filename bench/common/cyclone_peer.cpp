#include <dds/ddsc/dds_loan_api.h>

#include <cstdio>
#include <cstdlib>
#include <vector>

#include "bench/common/contender.h"
#include "bench/common/cyclone.h"
#include "messages.h"

namespace sft::bench {

namespace {

// The fastest configuration for large samples among those that were tried, with fragments and datagrams of
// other sizes down to the MTU. It has the largest datagrams, which IP fragments, buffers for several samples
// at both ends, and as many bytes that are not acknowledged yet.
constexpr const char* config = R"(
  <General><MaxMessageSize>65500B</MaxMessageSize><FragmentSize>65000B</FragmentSize></General>
  <Internal>
    <SocketReceiveBufferSize min="16MB"/><SocketSendBufferSize min="4MB"/>
    <Watermarks><WhcHigh>8MB</WhcHigh></Watermarks>
  </Internal>)";
constexpr const char* memory_config =
    "<SharedMemory><Enable>true</Enable><LogLevel>error</LogLevel></SharedMemory>";

CycloneQos qos_of(const Topic& topic, bool in_memory) {
  CycloneQos qos = cyclone_best_effort();
  if (topic.reliable) dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_INFINITY);
  // Samples in shared memory need a history of limited depth.
  if (in_memory) dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, static_cast<std::int32_t>(topic.depth));
  if (topic.reliable && !in_memory) dds_qset_history(qos.get(), DDS_HISTORY_KEEP_ALL, 0);
  return qos;
}

const dds_topic_descriptor_t& type_of(const Topic& topic) {
  return topic.bulk_bytes > 0 ? sft_bench_Bulk_desc : sft_bench_Small_desc;
}

/// A sample of either type. Both types begin with the number.
union Message {
  sft_bench_Small small{};
  sft_bench_Bulk bulk;
};

class CycloneWriter : public Writer {
 public:
  CycloneWriter(const CycloneParticipant& participant, const Topic& topic, bool in_memory)
      : writer_(participant.writer(type_of(topic), topic.name, qos_of(topic, in_memory).get())),
        data_(topic.bulk_bytes, 1) {
    if (in_memory && !dds_is_shared_memory_available(writer_)) {
      std::fprintf(stderr, "Cyclone DDS does not use shared memory\n");
      std::exit(1);
    }
    if (topic.bulk_bytes > 0) message_.bulk.data = {topic.bulk_bytes, topic.bulk_bytes, data_.data(), false};
  }

  std::size_t readers() const override { return CycloneParticipant::readers(writer_); }
  void write(std::uint64_t number) override {
    message_.small.number = number;
    dds_write(writer_, &message_);
  }
  void write_together(std::uint64_t first, std::uint64_t count) override {
    Writer::write_together(first, count);
    dds_write_flush(writer_);
  }

 private:
  const dds_entity_t writer_;
  std::vector<std::uint8_t> data_;
  Message message_{};
};

/// Takes every sample into the same memory, so that nothing is allocated.
class CycloneReader : public Reader {
 public:
  CycloneReader(const CycloneParticipant& participant, const Topic& topic, bool in_memory, Arrived arrived)
      : arrived_(std::move(arrived)),
        reader_(participant.reader(type_of(topic), topic.name, qos_of(topic, in_memory).get(),
                                   arrived_ ? take_all : nullptr, this)),
        wait_set_(checked(dds_create_waitset(participant.entity()))) {
    const dds_entity_t unread = checked(dds_create_readcondition(reader_, DDS_ANY_STATE));
    dds_waitset_attach(wait_set_, unread, 0);
  }
  ~CycloneReader() override { dds_delete(reader_); }  // ends its callbacks before the members are destroyed
  CycloneReader(const CycloneReader&) = delete;
  CycloneReader& operator=(const CycloneReader&) = delete;

  std::size_t writers() const override { return CycloneParticipant::writers(reader_); }
  void wait() override { dds_waitset_wait(wait_set_, nullptr, 0, DDS_SECS(1)); }
  std::uint64_t take() override { return take_from(reader_); }

 private:
  static void take_all(dds_entity_t reader, void* self) {
    auto& that = *static_cast<CycloneReader*>(self);
    while (const std::uint64_t number = that.take_from(reader)) that.arrived_(number);
  }
  std::uint64_t take_from(dds_entity_t reader) {
    void* sample = &message_;
    dds_sample_info_t info;
    while (dds_take(reader, &sample, &info, 1, 1) == 1) {
      if (info.valid_data) return message_.small.number;
    }
    return 0;
  }

  const Arrived arrived_;
  Message message_{};
  const dds_entity_t reader_;
  const dds_entity_t wait_set_;
};

/// Cyclone DDS 0.10.5 deprecates this function for a QoS that 0.10.2 does not have.
void set_batching(bool is_on) {
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
  dds_write_set_batch(is_on);
#pragma GCC diagnostic pop
}

class CyclonePeer : public Peer {
 public:
  explicit CyclonePeer(bool in_memory)
      : in_memory_(in_memory), participant_(in_memory ? memory_config : config) {}

  std::unique_ptr<Writer> writer(const Topic& topic) override {
    set_batching(topic.batching);
    return std::make_unique<CycloneWriter>(participant_, topic, in_memory_);
  }
  std::unique_ptr<Reader> reader(const Topic& topic, Arrived arrived) override {
    return std::make_unique<CycloneReader>(participant_, topic, in_memory_, std::move(arrived));
  }

 private:
  const bool in_memory_;
  const CycloneParticipant participant_;
};

}  // namespace

std::unique_ptr<Peer> cyclone_peer() { return std::make_unique<CyclonePeer>(false); }
std::unique_ptr<Peer> cyclone_memory_peer() { return std::make_unique<CyclonePeer>(true); }

}  // namespace sft::bench
