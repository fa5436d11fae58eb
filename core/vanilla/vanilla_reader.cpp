#include "core/vanilla/vanilla_reader.h"

#include <algorithm>
#include <array>
#include <vector>

#include "core/discovery/dds_domain.h"
#include "core/platform/quotes.h"
#include "core/vanilla/dds_names.h"
#include "core/vanilla/dds_qos.h"
#include "core/vanilla/type_hash.h"
#include "core/vanilla/vanilla_endpoints.h"

namespace sft::core {

namespace {

/// Each sample is taken as soon as it arrives, so few of them are ever in the cache of the DDS reader.
constexpr std::int32_t cached_samples = 16;
constexpr std::size_t writers_asked = 1024;

DdsQos qos_of(const Qos& requested, const std::string& user_data, bool hears) {
  DdsQos qos(dds_create_qos());
  const char* alone = "sft_presence";
  if (!hears) dds_qset_partition(qos.get(), 1, &alone);
  const bool is_reliable = requested.reliability == Reliability::reliable;
  dds_qset_reliability(qos.get(), is_reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, 0);
  if (requested.durability == Durability::transient_local)
    dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, cached_samples);
  if (requested.deadline.count() > 0) dds_qset_deadline(qos.get(), requested.deadline.count());
  const bool is_manual = requested.liveliness == Liveliness::manual_by_topic;
  const std::int64_t lease = requested.liveliness_lease.count();
  dds_qset_liveliness(qos.get(), is_manual ? DDS_LIVELINESS_MANUAL_BY_TOPIC : DDS_LIVELINESS_AUTOMATIC,
                      lease > 0 ? lease : DDS_INFINITY);
  dds_qset_userdata(qos.get(), user_data.data(), user_data.size());
  dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PROCESS);
  return qos;
}

}  // namespace

VanillaReader::VanillaReader(std::shared_ptr<VanillaDomain> domain, Spec spec)
    : domain_(std::move(domain)),
      spec_(std::move(spec)),
      type_name_(dds_type(spec_.reading.type->name(), spec_.names)),
      type_hash_(ros_type_hash(spec_.reading.type->type()).value_or("")) {}

Result<std::unique_ptr<VanillaReader>> VanillaReader::open(std::shared_ptr<VanillaDomain> domain, Spec spec) {
  std::unique_ptr<VanillaReader> reader(new VanillaReader(std::move(domain), std::move(spec)));
  if (Result<void> opened = reader->open(); !opened) return tl::unexpected(opened.error());
  return reader;
}

Result<void> VanillaReader::open() {
  const CycloneMessages messages;
  const std::string name = dds_topic(spec_.topic, spec_.names);
  const auto refused = [&](dds_return_t status) {
    return fail(Errc::system, "DDS topic " + in_quotes(name) + " of type " + in_quotes(type_name_) + ": " +
                                  dds_strretcode(status) + " (" + messages.text() + ")");
  };
  topic_ = raw_topic(domain_->participant(), name, type_name_, spec_.hears ? spec_.reading : RawReading{});
  if (topic_.entity < 0) return refused(topic_.entity);
  dds_listener_t* const listener = dds_create_listener(this);
  dds_lset_subscription_matched(
      listener, [](dds_entity_t reader, dds_subscription_matched_status_t status, void* self) {
        static_cast<VanillaReader*>(self)->match(reader, status.last_publication_handle);
      });
  dds_lset_data_available(
      listener, [](dds_entity_t reader, void* self) { static_cast<VanillaReader*>(self)->take(reader); });
  // A reader that only shows the subscriber to ROS 2 must not count as a DDS endpoint that receives
  // samples.
  const std::string user_data = endpoint_user_data(type_hash_, spec_.hears ? spec_.id : 0);
  const DdsQos qos = qos_of(requested_from_vanilla(spec_.qos), user_data, spec_.hears);
  reader_ = dds_create_reader(domain_->participant(), topic_.entity, qos.get(), listener);
  dds_delete_listener(listener);
  if (reader_ < 0) return refused(reader_);
  catch_up();
  return {};
}

/// Takes events that occurred while the reader was being made. The listener may have been called in that
/// time, when the reader could not be used yet.
void VanillaReader::catch_up() {
  std::vector<dds_instance_handle_t> writers(writers_asked);
  const dds_return_t matched = dds_get_matched_publications(reader_, writers.data(), writers.size());
  writers.resize(std::min(static_cast<std::size_t>(std::max(matched, 0)), writers.size()));
  for (const dds_instance_handle_t writer : writers) match(reader_, writer);
  take(reader_);
}

VanillaReader::~VanillaReader() {
  if (reader_ > 0) dds_delete(reader_);  // waits until no listener runs any more
  if (topic_.entity > 0) dds_delete(topic_.entity);
}

bool VanillaReader::is_matched(EndpointId writer) const {
  const Lock lock(mutex_);
  return std::ranges::any_of(
      writers_, [&](const auto& item) { return item.second.id == writer && item.second.is_matched; });
}

std::set<RawFault> VanillaReader::faults() const {
  const Lock lock(mutex_);
  return faults_;
}

/// Called when a writer has begun or ceased to match. Adds the writer to the known writers, or removes it.
void VanillaReader::match(dds_entity_t reader, dds_instance_handle_t writer) {
  const Writer now = look_up(reader, writer);
  {
    const Lock lock(mutex_);
    if (now.is_matched) {
      writers_[writer] = now;
    } else if (const auto known = writers_.find(writer); known != writers_.end()) {
      known->second.is_matched = false;
    }
    const auto has_departed = [](const auto& item) { return !item.second.is_matched; };
    if (std::ranges::count_if(writers_, has_departed) > static_cast<std::ptrdiff_t>(departed_max))
      std::erase_if(writers_, has_departed);
  }
  spec_.changed();
}

VanillaReader::Writer VanillaReader::look_up(dds_entity_t reader, dds_instance_handle_t writer) const {
  dds_builtintopic_endpoint_t* const announced = dds_get_matched_publication_data(reader, writer);
  if (announced == nullptr) return {.is_matched = false};
  const VanillaEndpoint endpoint = described(*announced);
  const bool is_ours = is_endpoint_of_sft(announced->qos);
  dds_builtintopic_free_endpoint(announced);
  const Qos requested = requested_from_vanilla(spec_.qos);
  return {.id = endpoint.id,
          .is_heard = !is_ours && why_not_heard(type_name_, type_hash_, requested, endpoint).empty()};
}

/// Returns the writer of a sample. A sample can arrive before the listener was called for the match of its
/// writer.
VanillaReader::Writer VanillaReader::writer_of(dds_entity_t reader, dds_instance_handle_t writer) {
  {
    const Lock lock(mutex_);
    if (const auto known = writers_.find(writer); known != writers_.end()) return known->second;
  }
  return look_up(reader, writer);
}

void VanillaReader::take(dds_entity_t reader) {
  bool some_arrived = false;
  {
    const Lock lock(taking_);
    while (take_some(reader, some_arrived)) continue;
  }
  if (some_arrived) spec_.wake();
}

/// Returns false if there are no more samples.
bool VanillaReader::take_some(dds_entity_t reader, bool& some_arrived) {
  std::array<ddsi_serdata*, cached_samples> samples{};
  std::array<dds_sample_info_t, cached_samples> infos{};
  const dds_return_t taken = dds_takecdr(reader, samples.data(), cached_samples, infos.data(), DDS_ANY_STATE);
  for (std::size_t i = 0; i < static_cast<std::size_t>(std::max(taken, 0)); ++i) {
    if (infos[i].valid_data) {
      const Writer writer = writer_of(reader, infos[i].publication_handle);
      some_arrived |= writer.is_heard && deliver(samples[i], writer, infos[i].source_timestamp);
    }
    ddsi_serdata_unref(samples[i]);
  }
  return taken > 0;
}

bool VanillaReader::deliver(const ddsi_serdata* data, const Writer& writer, std::int64_t source_stamp_ns) {
  RawArrival raw = raw_arrival(data);
  bool is_news = false;
  if (raw.fault != RawFault::none) {
    const Lock lock(mutex_);
    is_news = faults_.insert(raw.fault).second;
  }
  if (is_news) spec_.changed();
  return spec_.arrived({.writer = writer.id,
                        .sequence = raw.sequence,
                        .source_stamp_ns = source_stamp_ns,
                        .sample = std::move(raw.sample)});
}

}  // namespace sft::core
