#include <dds/ddsc/dds_loan_api.h>

#include <cstdio>
#include <cstdlib>
#include <utility>
#include <vector>

#include "bench/common/contender.h"
#include "bench/common/cyclone.h"
#include "bench/common/message_set.h"
#include "messages.h"
#include "tests/support/cyclone_cdr.h"

namespace sft::bench {

namespace {

// The fastest configuration for large samples among those that were tried, with fragments and datagrams of
// various sizes down to the MTU. It has the largest datagrams, which IP fragments. Writer and reader have
// buffers for several samples, and the bytes of as many samples may be unacknowledged.
constexpr const char* fastest = R"(
  <General><MaxMessageSize>65500B</MaxMessageSize><FragmentSize>65000B</FragmentSize></General>
  <Internal>
    <SocketReceiveBufferSize min="16MB"/><SocketSendBufferSize min="4MB"/>
    <Watermarks><WhcHigh>8MB</WhcHigh></Watermarks>
  </Internal>)";
constexpr const char* in_memory =
    "<SharedMemory><Enable>true</Enable><LogLevel>error</LogLevel></SharedMemory>";
constexpr const char* unicast = "<General><AllowMulticast>spdp</AllowMulticast></General>";

struct Ways {
  std::string config;
  bool in_memory = false;
  bool usual = false;  ///< true: the contender has its default settings
};

CycloneQos qos_of(const Topic& topic, const Ways& ways) {
  CycloneQos qos = cyclone_best_effort();
  if (topic.durable) {
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
    dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
    return qos;
  }
  if (topic.reliable)
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, ways.usual ? DDS_SECS(1) : DDS_INFINITY);
  // Samples in shared memory need a history of limited depth.
  if (ways.in_memory || ways.usual)
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, static_cast<std::int32_t>(topic.depth));
  else if (topic.reliable)
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_ALL, 0);
  return qos;
}

const dds_topic_descriptor_t& type_of(const Topic& topic) {
  if (topic.messages) return topic.messages->cyclone_type();
  return topic.bulk_bytes > 0 ? sft_bench_Bulk_desc : sft_bench_Small_desc;
}

void require_memory(dds_entity_t writer) {
  if (dds_is_shared_memory_available(writer)) return;
  std::fprintf(stderr, "Cyclone DDS does not use shared memory\n");
  std::exit(1);
}

/// Memory for a sample with a number. The number is the first member in all types of such samples.
union Message {
  sft_bench_Small small{};
  sft_bench_Bulk bulk;
};

class CycloneWriter : public Writer {
 public:
  CycloneWriter(const CycloneParticipant& participant, const Topic& topic, const Ways& ways)
      : writer_(participant.writer(type_of(topic), topic.name, qos_of(topic, ways).get())),
        data_(topic.bulk_bytes, 1) {
    if (ways.in_memory) require_memory(writer_);
    if (topic.bulk_bytes > 0) message_.bulk.data = {topic.bulk_bytes, topic.bulk_bytes, data_.data(), false};
    if (!topic.messages) return;
    for (const auto& body : topic.messages->bodies()) {
      owners_.push_back(std::make_unique<test::CycloneReader>(type_of(topic)));
      messages_.push_back(owners_.back()->deserialize(body));
      if (messages_.back() == nullptr) std::abort();
    }
  }

  std::size_t readers() const override { return CycloneParticipant::readers(writer_); }
  void write(std::uint64_t number) override {
    message_.small.number = number;
    dds_write(writer_, messages_.empty() ? &message_ : messages_[number]);
  }
  void write_together(std::uint64_t first, std::uint64_t count) override {
    Writer::write_together(first, count);
    dds_write_flush(writer_);
  }

 private:
  const dds_entity_t writer_;
  std::vector<std::uint8_t> data_;
  Message message_{};
  std::vector<std::unique_ptr<test::CycloneReader>> owners_;
  std::vector<const void*> messages_;
};

/// Takes every sample into the same memory, so that nothing is allocated.
class CycloneReader : public Reader {
 public:
  CycloneReader(const CycloneParticipant& participant, const Topic& topic, const Ways& ways, Arrived arrived)
      : participant_(participant),
        type_(type_of(topic)),
        arrived_(std::move(arrived)),
        reader_(participant.reader(type_, topic.name, qos_of(topic, ways).get(),
                                   arrived_ ? take_all : nullptr, this)) {}
  ~CycloneReader() override {
    dds_delete(reader_);  // ends the callbacks of the reader before the members are destroyed
    dds_sample_free(message_, &type_, DDS_FREE_ALL);
  }

  std::size_t writers() const override { return CycloneParticipant::writers(reader_); }
  void wait() override {
    if (wait_set_ == 0) {
      wait_set_ = checked(dds_create_waitset(participant_.entity()));
      dds_waitset_attach(wait_set_, checked(dds_create_readcondition(reader_, DDS_ANY_STATE)), 0);
    }
    dds_waitset_wait(wait_set_, nullptr, 0, DDS_SECS(1));
  }
  std::uint64_t take() override { return take_from(reader_) ? number() : 0; }

 private:
  static void take_all(dds_entity_t reader, void* self) {
    auto& that = *static_cast<CycloneReader*>(self);
    while (that.take_from(reader)) that.arrived_(that.number());
  }
  bool take_from(dds_entity_t reader) {
    dds_sample_info_t info;
    while (dds_take(reader, &message_, &info, 1, 1) == 1) {
      if (info.valid_data) return true;
    }
    return false;
  }
  /// Returns the number of the sample. Must be called only for samples with a number.
  std::uint64_t number() const { return *static_cast<const std::uint64_t*>(message_); }

  const CycloneParticipant& participant_;
  const dds_topic_descriptor_t& type_;
  const Arrived arrived_;
  void* message_ = dds_alloc(type_.m_size);
  const dds_entity_t reader_;
  dds_entity_t wait_set_ = 0;
};

/// Turns batching on or off. Cyclone DDS 0.10.5 deprecates this function in favour of a QoS that 0.10.2
/// lacks.
void set_batching(bool is_on) {
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
  dds_write_set_batch(is_on);
#pragma GCC diagnostic pop
}

class CyclonePeer : public Peer {
 public:
  explicit CyclonePeer(Ways ways) : ways_(std::move(ways)), participant_(ways_.config) {}

  std::unique_ptr<Writer> writer(const Topic& topic) override {
    set_batching(topic.batching);
    return std::make_unique<CycloneWriter>(participant_, topic, ways_);
  }
  std::unique_ptr<Reader> reader(const Topic& topic, Arrived arrived) override {
    return std::make_unique<CycloneReader>(participant_, topic, ways_, std::move(arrived));
  }
  /// Waits until a writer is announced.
  void know_writer(const Topic&) override {
    constexpr double timeout_s = 60;  // long enough for the discovery of many nodes that start at once
    const dds_entity_t announcements = checked(
        dds_create_reader(participant_.entity(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr));
    const auto announced = [&] {
      void* sample = nullptr;
      dds_sample_info_t info;
      const dds_return_t count = dds_take(announcements, &sample, &info, 1, 1);
      if (count > 0) dds_return_loan(announcements, &sample, count);
      return count > 0;
    };
    wait_until(announced, timeout_s);
    dds_delete(announcements);
  }

 private:
  const Ways ways_;
  const CycloneParticipant participant_;
};

std::unique_ptr<Peer> peer(Ways ways) { return std::make_unique<CyclonePeer>(std::move(ways)); }

}  // namespace

std::unique_ptr<Peer> cyclone_peer() { return peer({.config = fastest}); }
std::unique_ptr<Peer> cyclone_usual_peer() { return cyclone_peer_with(""); }
std::unique_ptr<Peer> cyclone_unicast_peer() { return cyclone_peer_with(unicast); }
std::unique_ptr<Peer> cyclone_peer_with(const std::string& config) {
  return peer({.config = config, .usual = true});
}
std::unique_ptr<Peer> cyclone_memory_peer() { return peer({.config = in_memory, .in_memory = true}); }

}  // namespace sft::bench
