// The suite with writers and readers of plain DDS, which know nothing of SFT. A subscriber receives the
// samples of such a writer through its DDS reader and its inlet. A publisher sends samples to such readers
// through its outlet. Each writer has its own topic, so that a reader is connected only to the writers that
// it names. conformance.md says which tests DDS cannot pass.
#include <dds/dds.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <functional>
#include <map>
#include <string_view>
#include <utility>

#include "core/subscribe/vanilla_inlet.h"
#include "core/vanilla/dds_names.h"
#include "core/vanilla/dds_qos.h"
#include "core/vanilla/raw_sample.h"
#include "core/vanilla/vanilla_domain.h"
#include "core/vanilla/vanilla_outlet.h"
#include "core/vanilla/vanilla_reader.h"
#include "core/vanilla/vanilla_writer.h"
#include "sft/detail/fnv1a.h"
#include "tests/conformance/conformance.h"
#include "tests/support/isolated_host.h"

namespace sft::conformance {
namespace {

using namespace detail;
using core::EndpointId;
using core::SampleHandle;
using core::SendStatus;

constexpr std::size_t sample_bytes_max = std::size_t{16} << 20;
constexpr const char* on_this_host =
    "<General><AllowMulticast>false</></>,<Discovery><ParticipantIndex>auto</><MaxAutoParticipantIndex>32</>"
    "<Peers><Peer address=\"localhost\"/></></>,"
    "<Internal><SocketReceiveBufferSize min=\"default\" max=\"4MB\"/></>";

std::string topic_of(EndpointId writer) { return "writer_" + std::to_string(writer); }

/// The facts about a writer that readers need.
struct DdsEnd {
  EndpointId id = 0;                                ///< that DDS readers have for it
  std::function<bool(const core::Guid&)> serves{};  ///< whether a reader is matched
};

/// The writers of the test, by the ids that the suite gives them.
struct DdsWriters {
  core::Mutex mutex;
  std::map<EndpointId, DdsEnd> ends SFT_GUARDED_BY(mutex);

  DdsEnd of(EndpointId id) {
    const core::Lock lock(mutex);
    const auto found = ends.find(id);
    return found == ends.end() ? DdsEnd{} : found->second;
  }
  void enter(EndpointId id, DdsEnd end) {
    const core::Lock lock(mutex);
    ends[id] = std::move(end);
  }
};

/// Returns the id that readers have for a DDS writer.
EndpointId id_of(const core::Guid& writer) {
  Fnv1a id;
  id.add(std::string_view(reinterpret_cast<const char*>(writer.data()), writer.size()));
  return id.value();
}

bool is_matched(dds_entity_t writer, const core::Guid& reader) {
  std::vector<dds_instance_handle_t> handles(64);
  const dds_return_t count = dds_get_matched_subscriptions(writer, handles.data(), handles.size());
  handles.resize(static_cast<std::size_t>(std::max(count, 0)));
  return std::ranges::any_of(handles, [&](dds_instance_handle_t handle) {
    dds_builtintopic_endpoint_t* const data = dds_get_matched_subscription_data(writer, handle);
    if (data == nullptr) return false;
    const bool is_it = core::guid_of(data->key) == reader;
    dds_builtintopic_free_endpoint(data);
    return is_it;
  });
}

/// The state that a transport shares with its ports.
struct DdsNode {
  explicit DdsNode(std::shared_ptr<DdsWriters> shared) : writers(std::move(shared)) {
    core::VanillaPlan plan{.user_config = on_this_host};
    // Participants of one Cyclone domain would not talk to each other. Another lease makes another domain.
    static std::atomic<int> lease_s{1000};
    plan.user_config += ",<Discovery><LeaseDuration>" + std::to_string(++lease_s) + " s</></>";
    domain = core::VanillaDomain::of(plan).value();
  }
  const std::shared_ptr<DdsWriters> writers;
  std::shared_ptr<core::VanillaDomain> domain;
  const std::shared_ptr<core::BufferPool> pool = core::BufferPool::make(std::size_t{512} << 20);
  std::atomic<bool> closed{false};
  std::atomic<std::uint64_t> over_limit{0};
};

/// DDS itself knows its readers, and each of them gets all samples.
class DdsWriter : public core::NetworkWriter {
 public:
  explicit DdsWriter(std::shared_ptr<DdsNode> node) : node_(std::move(node)) {}

  SendStatus send(const SampleHandle& sample) noexcept override {
    return send_begun(sample, core::Reach::usual_routes);
  }
  void set_timeout(std::chrono::nanoseconds) noexcept override {}
  bool takes_postponed() const noexcept override { return false; }
  void set_routes(std::vector<core::Route>) override {}
  void send_history(const core::Route&, std::vector<SampleHandle>) override {}
  bool history_sent(EndpointId) noexcept override { return true; }
  Counters counters() const noexcept override { return {}; }
  std::string multicast(EndpointId) const override { return {}; }
  std::string path_trouble(EndpointId) const override { return {}; }

 protected:
  const std::shared_ptr<DdsNode> node_;

 private:
  virtual bool write(const SampleHandle& sample) noexcept = 0;

  void begin_sample() noexcept override {}
  SendStatus send_begun(const SampleHandle& sample, core::Reach) noexcept override {
    if (node_->closed) return SendStatus::lost_port;
    if (sample->header().body_bytes > sample_bytes_max) {
      ++node_->over_limit;
      return SendStatus::dropped;
    }
    // Publishers write the encapsulation before each body; the samples of the suite have none.
    std::byte* const body = sample->data + sample->header().body_offset;
    std::memcpy(body - encapsulation_bytes, encapsulation_cdr_le.data(), encapsulation_bytes);
    return write(sample) ? SendStatus::sent : SendStatus::dropped;
  }
  void miss_begun() noexcept override {}
  void hold(core::BatchTimeout) noexcept override {}
  std::size_t flush() noexcept override { return 0; }
};

/// A writer that knows nothing of SFT.
class PlainWriter final : public DdsWriter {
 public:
  PlainWriter(const core::WriterSpec& spec, std::shared_ptr<DdsNode> node)
      : DdsWriter(std::move(node)), id_(spec.id), slots_(spec.type->index_slots()) {
    const dds_entity_t participant = node_->domain->participant();
    topic_ = core::raw_topic(participant, core::dds_topic(topic_of(id_), core::DdsNames::ros2),
                             core::dds_type(spec.type->name(), core::DdsNames::ros2));
    const core::DdsQos qos(dds_create_qos());
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_INFINITY);
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_ALL, 0);
    writer_ = dds_create_writer(participant, topic_.entity, qos.get(), nullptr);
    node_->writers->enter(id_, {id_of(core::guid_of(writer_)), [writer = writer_](const core::Guid& reader) {
                                  return is_matched(writer, reader);
                                }});
  }
  ~PlainWriter() override {
    node_->writers->enter(id_, {});
    if (!node_->closed) dds_wait_for_acks(writer_, DDS_SECS(10));
    dds_delete(writer_);
    dds_delete(topic_.entity);
  }

 private:
  bool write(const SampleHandle& sample) noexcept override {
    return dds_forwardcdr(writer_, core::raw_sample(topic_.type, sample, slots_)) == DDS_RETCODE_OK;
  }

  const EndpointId id_;
  const std::size_t slots_;
  core::RawTopic topic_;
  dds_entity_t writer_ = 0;
};

/// The outlet and the DDS writer of a publisher. They leave out samples that come too fast, so this publisher
/// waits for its readers.
class ServingWriter final : public DdsWriter {
 public:
  ServingWriter(const core::WriterSpec& spec, std::shared_ptr<DdsNode> node)
      : DdsWriter(std::move(node)),
        id_(spec.id),
        writer_(core::VanillaWriter::open(
                    node_->domain,
                    {.id = spec.id, .topic = topic_of(spec.id), .type = spec.type, .readers_changed = [] {}})
                    .value()) {
    EXPECT_TRUE(outlet_.start(core::ThreadSpec("dds-send", {})));
    node_->writers->enter(
        id_, {id_of(writer_->guid()), [this](const core::Guid& reader) {
                const auto known =
                    node_->domain->readers().of(core::dds_topic(topic_of(id_), core::DdsNames::ros2));
                return writer_->readers() == known.size() &&
                       std::ranges::find(known, reader, &core::VanillaEndpoint::key) != known.end();
              }});
  }
  ~ServingWriter() override {
    node_->writers->enter(id_, {});
    if (!node_->closed) (void)writer_->is_acknowledged(std::chrono::seconds(10));
    outlet_.close();
  }

 private:
  bool write(const SampleHandle& sample) noexcept override {
    outlet_.send(sample);
    ++sent_;
    for (std::uint64_t n = written_; n < sent_; n = written_) written_.wait(n);
    return sent_ % kept_samples != 0 || writer_->is_acknowledged(std::chrono::seconds(10));
  }

  static constexpr std::uint64_t kept_samples = 8;  ///< fewer than the DDS writer keeps

  const EndpointId id_;
  const std::shared_ptr<core::VanillaWriter> writer_;
  std::uint64_t sent_ = 0;
  std::atomic<std::uint64_t> written_{0};
  core::VanillaOutlet outlet_{[this](const SampleHandle& sample) {
                                const bool done = writer_->write(sample);
                                ++written_;
                                written_.notify_all();
                                return done;
                              },
                              0};
};

/// A reader on the topic of one writer.
class DdsReader {
 public:
  struct Spec {
    std::shared_ptr<DdsNode> node;
    std::string topic;
    const TypeSupport* type;
    std::function<bool(core::VanillaArrival)> arrived;
    std::function<void()> wake;
  };
  virtual ~DdsReader() = default;
  virtual core::Guid guid() const = 0;
  virtual bool is_matched(EndpointId writer) const = 0;
};

/// The DDS reader of a subscriber.
class HearingReader final : public DdsReader {
 public:
  explicit HearingReader(const Spec& spec)
      : reader_(core::VanillaReader::open(spec.node->domain,
                                          {.id = 1,
                                           .topic = spec.topic,
                                           .reading = {.type = spec.type, .memory = spec.node->pool},
                                           .qos = {.reliability = Reliability::reliable},
                                           .arrived = spec.arrived,
                                           .wake = spec.wake,
                                           .changed = [] {}})
                    .value()) {}
  core::Guid guid() const override { return reader_->guid(); }
  bool is_matched(EndpointId writer) const override { return reader_->is_matched(writer); }

 private:
  const std::unique_ptr<core::VanillaReader> reader_;
};

/// A reader that knows nothing of SFT.
class PlainReader final : public DdsReader {
 public:
  explicit PlainReader(const Spec& spec) : spec_(spec) {
    const dds_entity_t participant = spec.node->domain->participant();
    topic_ = core::raw_topic(participant, core::dds_topic(spec.topic, core::DdsNames::ros2),
                             core::dds_type(spec.type->name(), core::DdsNames::ros2),
                             {.type = spec.type, .memory = spec.node->pool});
    const core::DdsQos qos(dds_create_qos());
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, 0);
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_ALL, 0);
    dds_listener_t* const listener = dds_create_listener(this);
    dds_lset_data_available(
        listener, [](dds_entity_t reader, void* self) { static_cast<PlainReader*>(self)->take(reader); });
    reader_ = dds_create_reader(participant, topic_.entity, qos.get(), listener);
    dds_delete_listener(listener);
  }
  ~PlainReader() override {
    dds_delete(reader_);  // Cyclone waits for the listener
    dds_delete(topic_.entity);
  }
  core::Guid guid() const override { return core::guid_of(reader_); }
  bool is_matched(EndpointId) const override {
    dds_subscription_matched_status_t status{};
    dds_get_subscription_matched_status(reader_, &status);
    return status.current_count == 1;
  }

 private:
  void take(dds_entity_t reader) {
    ddsi_serdata* data = nullptr;
    dds_sample_info_t info{};
    while (dds_takecdr(reader, &data, 1, &info, DDS_ANY_STATE) > 0) {
      if (info.valid_data) {
        core::RawArrival raw = core::raw_arrival(data);
        spec_.arrived({.sequence = raw.sequence,
                       .source_stamp_ns = info.source_timestamp,
                       .sample = std::move(raw.sample)});
      }
      ddsi_serdata_unref(data);
    }
    spec_.wake();
  }

  const Spec spec_;
  core::RawTopic topic_;
  dds_entity_t reader_ = 0;
};

/// A reader of the suite: one DDS reader for each writer that it is connected to.
template <class ReaderKind>
class DdsReaderPort final : public core::NetworkReader {
 public:
  DdsReaderPort(const core::ReaderSpec& spec, std::shared_ptr<DdsNode> node)
      : spec_(spec),
        node_(std::move(node)),
        inlet_(std::make_shared<core::VanillaInlet>(*spec.type, std::max(spec.depth, 1U), spec.depth_bytes)) {
  }

  SampleHandle take() noexcept override { return inlet_->take(); }
  Result<void> connect(const core::Source& source) override {
    const EndpointId writer = source.writer;
    readers_[writer] =
        std::make_unique<ReaderKind>(DdsReader::Spec{node_, topic_of(writer), spec_.type,
                                                     [inlet = inlet_, writer](core::VanillaArrival arrival) {
                                                       arrival.writer = writer;
                                                       return inlet->put(arrival);
                                                     },
                                                     [this] { spec_.listener->arrived(); }});
    return {};
  }
  /// Both ends have to know each other.
  bool connected(EndpointId writer) const noexcept override {
    const auto reader = readers_.find(writer);
    const DdsEnd end = node_->writers->of(writer);
    if (reader == readers_.end() || !end.serves) return false;
    return reader->second->is_matched(end.id) && end.serves(reader->second->guid());
  }
  void disconnect(EndpointId writer) noexcept override { readers_.erase(writer); }
  core::HistoryProgress history(EndpointId) const noexcept override { return core::HistoryProgress::came; }
  std::uint64_t arrivals(EndpointId writer) noexcept override { return inlet_->arrivals(writer); }
  Counters counters() const noexcept override { return inlet_->counters(); }
  void accept(std::vector<core::Accepted> accepted) override {
    inlet_->ask(accepted.back().wanted.selection, accepted.back().wanted.min_period_us);
  }
  void announced(const core::Source&) override {}
  bool receive(const core::Waiting&) noexcept override { return false; }
  void share_reader() override {}

 private:
  const core::ReaderSpec spec_;
  const std::shared_ptr<DdsNode> node_;
  const std::shared_ptr<core::VanillaInlet> inlet_;
  std::map<EndpointId, std::unique_ptr<DdsReader>> readers_;  ///< by writer
};

template <class WriterKind, class ReaderKind>
class DdsTransport final : public core::Network {
 public:
  explicit DdsTransport(std::shared_ptr<DdsWriters> writers)
      : node_(std::make_shared<DdsNode>(std::move(writers))) {}
  ~DdsTransport() override { node_->closed = true; }

  core::Availability poll(std::chrono::steady_clock::time_point) override {
    return core::Availability::ready;
  }
  std::size_t max_sample_bytes() const noexcept override { return sample_bytes_max; }
  std::string description() const override { return "DDS"; }
  Counters counters() const noexcept override { return {.over_limit = node_->over_limit}; }
  Result<std::unique_ptr<core::NetworkWriter>> open_writer(const core::WriterSpec& spec) override {
    return std::make_unique<WriterKind>(spec, node_);
  }
  Result<std::unique_ptr<core::NetworkReader>> open_reader(const core::ReaderSpec& spec) override {
    return std::make_unique<DdsReaderPort<ReaderKind>>(spec, node_);
  }
  std::vector<core::UdpAddress> addresses() const override { return {}; }
  std::vector<core::Link> links() const override { return {}; }
  bool network_changed() noexcept override { return false; }
  void wake_receiver() noexcept override {}
  std::chrono::steady_clock::time_point next_poll() const override {
    return std::chrono::steady_clock::time_point::max();
  }
  void add_to(NodeStatus&) const override {}

 private:
  const std::shared_ptr<DdsNode> node_;
};

template <class WriterKind, class ReaderKind>
class VanillaMedium final : public Medium {
 public:
  std::string refusal() override { return test::isolation_refusal(); }
  Traits traits() const override { return {.projects = false, .counts_before_first_taken = false}; }
  AnyTransport open() override {
    return std::unique_ptr<core::Network>(new DdsTransport<WriterKind, ReaderKind>(writers_));
  }
  core::Locator locator(const AnyTransport&, const core::DoorbellAddress& bell) override { return bell; }

 private:
  const std::shared_ptr<DdsWriters> writers_ = std::make_shared<DdsWriters>();
};

const auto both_ways = testing::Values(
    MediumChoice{"VanillaWriters", std::make_unique<VanillaMedium<PlainWriter, HearingReader>>},
    MediumChoice{"VanillaReaders", std::make_unique<VanillaMedium<ServingWriter, PlainReader>>});
INSTANTIATE_TEST_SUITE_P(Dds, Conformance, both_ways, name_of);

// DDS has no back pressure by reader, no history for one reader, no masks and no routes.
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(BackPressure);
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(LateReaders);
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(Projection);
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(Transmissions);

}  // namespace
}  // namespace sft::conformance
