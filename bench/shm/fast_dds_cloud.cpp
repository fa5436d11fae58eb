#include "bench/shm/fast_dds_cloud.h"

#include <fastdds/dds/core/LoanableSequence.hpp>

#include "bench/common/fast_dds_point_cloud.h"

namespace sft::bench {

namespace {

namespace dds = fast::dds;
using Standard = sensor_msgs::msg::PointCloud2;

struct Fixed {
  std::uint32_t height;
  std::uint32_t width;
  std::uint8_t data[sent_cloud_bytes];
};

// The best of all sizes that were tried, from pieces of 64 KB to the whole cloud: Fast DDS writes a piece
// while the reader reads the one before.
constexpr std::uint32_t message_bytes_max = 1'000'000;
constexpr std::uint32_t segment_bytes = 20'000'000;

using StandardType = fast::PointCloudType;
using FixedType = fast::PlainType<Fixed>;

constexpr const char* topic = "points";
constexpr const char* fixed_type = "sft_bench::FixedCloud";

std::shared_ptr<fast::transports::SharedMemTransportDescriptor> shared_memory() {
  auto transport = std::make_shared<fast::transports::SharedMemTransportDescriptor>();
  transport->segment_size(segment_bytes);
  transport->max_message_size(message_bytes_max);
  return transport;
}

class Writer {
 public:
  explicit Writer(fast::AnyType* type)
      : participant_(shared_memory()),
        writer_(participant_.writer(participant_.topic(topic, type),
                                    fast::best_effort(dds::DATAWRITER_QOS_DEFAULT))) {}

  bool serves(std::size_t readers) const { return fast::readers(writer_) == readers; }

 protected:
  fast::Participant participant_;
  dds::DataWriter& writer_;
};

class StandardWriter : public Writer {
 public:
  StandardWriter() : Writer(new StandardType) {}
  void prepare(std::uint64_t number) { cloud_.width = static_cast<std::uint32_t>(number); }
  void publish() { fast::write(writer_, &cloud_); }

 private:
  Standard cloud_ = cloud(sent_cloud_bytes);
};

class FixedWriter : public Writer {
 public:
  FixedWriter() : Writer(new FixedType(fixed_type)) {}
  void prepare(std::uint64_t number) {
    if (!fast::is_ok(writer_.loan_sample(loan_))) fast::give_up("no loan");
    auto& cloud = *static_cast<Fixed*>(loan_);
    cloud.height = 1;
    cloud.width = static_cast<std::uint32_t>(number);
  }
  void publish() { fast::write(writer_, loan_); }

 private:
  void* loan_ = nullptr;
};

class Reader : private dds::DataReaderListener {
 public:
  std::size_t writers() const { return fast::writers(reader_); }

 protected:
  Reader(fast::AnyType* type, Arrived arrived)
      : arrived_(std::move(arrived)),
        participant_(shared_memory()),
        reader_(participant_.reader(participant_.topic(topic, type),
                                    fast::best_effort(dds::DATAREADER_QOS_DEFAULT), this)) {}

  const Arrived arrived_;

 private:
  fast::Participant participant_;
  dds::DataReader& reader_;
};

/// Deserializes every sample into the same memory.
class StandardReader : public Reader {
 public:
  explicit StandardReader(Arrived arrived) : Reader(new StandardType, std::move(arrived)) {}

 private:
  void on_data_available(dds::DataReader* reader) override {
    dds::SampleInfo info;
    while (fast::is_ok(reader->take_next_sample(&cloud_, &info))) {
      if (info.valid_data) arrived_(std::uint64_t{cloud_.height} * cloud_.width);
    }
  }

  Standard cloud_;
};

/// Reads samples in place.
class FixedReader : public Reader {
 public:
  explicit FixedReader(Arrived arrived) : Reader(new FixedType(fixed_type), std::move(arrived)) {}

 private:
  void on_data_available(dds::DataReader* reader) override {
    dds::LoanableSequence<Fixed> clouds;
    dds::SampleInfoSeq infos;
    while (fast::is_ok(reader->take(clouds, infos))) {
      for (dds::LoanableCollection::size_type i = 0; i < infos.length(); ++i) {
        if (infos[i].valid_data) arrived_(std::uint64_t{clouds[i].height} * clouds[i].width);
      }
      reader->return_loan(clouds, infos);
    }
  }
};

template <class W, class R>
std::vector<double> times(const Transfer& transfer) {
  return run_pair({.sender =
                       [&](Exchange& exchange) {
                         W writer;
                         send_each(exchange, transfer, writer);
                       },
                   .receiver = [&](Exchange& exchange) { be_called<R>(exchange, transfer); }},
                  transfer.messages);
}

}  // namespace

std::vector<double> fast_dds_standard(const Transfer& transfer) {
  return times<StandardWriter, StandardReader>(transfer);
}

std::vector<double> fast_dds_fixed(const Transfer& transfer) {
  return times<FixedWriter, FixedReader>(transfer);
}

}  // namespace sft::bench
