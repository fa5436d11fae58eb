#include "bench/shm/cyclone_cloud.h"

#include <dds/ddsc/dds_loan_api.h>

#include <cstdio>
#include <cstdlib>

#include "bench/common/cyclone.h"
#include "bench/common/cyclone_point_cloud.h"
#include "fixed_cloud.h"

namespace sft::bench {

namespace {

using Standard = sensor_msgs_msg_PointCloud2;
using Fixed = sft_bench_FixedCloud;

constexpr const char* config = "<SharedMemory><Enable>true</Enable><LogLevel>error</LogLevel></SharedMemory>";
constexpr std::int64_t connecting_us = 300'000;  // iceoryx connects ports every 100 ms

constexpr const char* topic = "points";

template <class T>
const dds_topic_descriptor_t& descriptor();
template <>
const dds_topic_descriptor_t& descriptor<Standard>() {
  return sensor_msgs_msg_PointCloud2_desc;
}
template <>
const dds_topic_descriptor_t& descriptor<Fixed>() {
  return sft_bench_FixedCloud_desc;
}

class Writer {
 public:
  explicit Writer(const dds_topic_descriptor_t& type)
      : writer_(participant_.writer(type, topic, cyclone_best_effort().get())) {
    if (dds_is_shared_memory_available(writer_)) return;
    std::fprintf(stderr, "Cyclone DDS does not use shared memory\n");
    std::exit(1);
  }

  bool serves(std::size_t readers) const {
    if (CycloneParticipant::readers(writer_) != readers) return false;
    sleep_us(connecting_us);
    return true;
  }

 protected:
  const CycloneParticipant participant_{config};
  const dds_entity_t writer_;
};

class StandardWriter : public Writer {
 public:
  StandardWriter() : Writer(descriptor<Standard>()) {}

  void prepare(std::uint64_t number) { cloud_.message().width = static_cast<std::uint32_t>(number); }
  void publish() { dds_write(writer_, &cloud_.message()); }

 private:
  CyclonePointCloud cloud_{sent_cloud_bytes};
};

class FixedWriter : public Writer {
 public:
  FixedWriter() : Writer(descriptor<Fixed>()) {}

  void prepare(std::uint64_t number) {
    void* loan = nullptr;
    if (dds_loan_sample(writer_, &loan) != DDS_RETCODE_OK) std::abort();
    loan_ = static_cast<Fixed*>(loan);
    loan_->height = 1;
    loan_->width = static_cast<std::uint32_t>(number);
  }
  void publish() { dds_write(writer_, loan_); }

 private:
  Fixed* loan_ = nullptr;
};

/// Takes every sample into the same memory, so that nothing is allocated.
template <class T>
class Reader {
 public:
  explicit Reader(Arrived arrived)
      : arrived_(std::move(arrived)),
        reader_(participant_.reader(descriptor<T>(), topic, cyclone_best_effort().get(), take, this)) {}
  ~Reader() { dds_delete(reader_); }  // ends its callbacks before the members are destroyed
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  std::size_t writers() const { return CycloneParticipant::writers(reader_); }

 private:
  static void take(dds_entity_t reader, void* self) {
    auto& that = *static_cast<Reader*>(self);
    void* sample = that.message_;
    dds_sample_info_t info;
    while (dds_take(reader, &sample, &info, 1, 1) == 1) {
      if (info.valid_data) that.arrived_(std::uint64_t{that.message_->height} * that.message_->width);
    }
  }

  const Arrived arrived_;
  T* const message_ = static_cast<T*>(dds_alloc(sizeof(T)));
  const CycloneParticipant participant_{config};
  const dds_entity_t reader_;
};

template <class W, class R>
std::vector<double> times(const Transfer& transfer, const Roudi& roudi) {
  return run_pair({.sender =
                       [&](Exchange& exchange) {
                         W writer;
                         send_each(exchange, transfer, writer);
                       },
                   .receiver = [&](Exchange& exchange) { be_called<R>(exchange, transfer); },
                   .enter_sender = [&] { roudi.enter(); },
                   .enter_receiver = [&] { roudi.enter(); }},
                  transfer.messages);
}

}  // namespace

std::vector<double> cyclone_standard(const Transfer& transfer, const Roudi& roudi) {
  return times<StandardWriter, Reader<Standard>>(transfer, roudi);
}

std::vector<double> cyclone_fixed(const Transfer& transfer, const Roudi& roudi) {
  return times<FixedWriter, Reader<Fixed>>(transfer, roudi);
}

}  // namespace sft::bench
