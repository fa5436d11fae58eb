#include "core/vanilla/ros_graph.h"

#include <utility>

#include "core/discovery/participant_data.h"
#include "core/platform/clock.h"
#include "core/vanilla/dds_names.h"
#include "core/vanilla/dds_qos.h"
#include "core/vanilla/vanilla_endpoints.h"

namespace sft::core {

namespace {

constexpr const char* graph_type = "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_";
/// The published hash of this type as of Iron. Earlier distributions have no hashes.
constexpr const char* graph_user_data =
    "typehash=RIHS01_91a0593bacdcc50ea9bdcf849a938b128412cc1ea821245c663bcd26f83c295e;";
/// The memory for messages that are being read, and for the last message that was written. A message that
/// needs more memory is not read.
constexpr std::size_t message_bytes_max = 1 << 20;

/// Returns the QoS that rmw_dds_common uses for the topic.
DdsQos qos_of_graph() {
  DdsQos qos(dds_create_qos());
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
  dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
  const std::string user_data = graph_user_data + std::string(vanilla_mark);
  dds_qset_userdata(qos.get(), user_data.data(), user_data.size());
  dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PROCESS);
  return qos;
}

}  // namespace

RosGraph::RosGraph(dds_entity_t participant, std::optional<GuidBytes> expected)
    : participant_(participant),
      expected_(expected),
      reading_{.memory = BufferPool::make(message_bytes_max)},
      topic_(raw_topic(participant, ros_graph_topic, graph_type, reading_)) {
  if (topic_.entity < 0) return;
  dds_listener_t* const listener = dds_create_listener(this);
  dds_lset_data_available(
      listener, [](dds_entity_t reader, void* self) { static_cast<RosGraph*>(self)->take(reader); });
  dds_lset_subscription_matched(listener,
                                [](dds_entity_t, dds_subscription_matched_status_t status, void* self) {
                                  if (status.current_count_change < 0)
                                    static_cast<RosGraph*>(self)->forget(status.last_publication_handle);
                                });
  const DdsQos qos = qos_of_graph();
  // All writers share one instance of the topic. Each message is taken at once.
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_ALL, 0);
  reader_ = dds_create_reader(participant, topic_.entity, qos.get(), listener);
  dds_delete_listener(listener);
  // Takes messages that arrived before Cyclone could be asked about their writers
  if (reader_ > 0) take(reader_);
}

RosGraph::~RosGraph() {
  if (reader_ > 0) dds_delete(reader_);
  {
    const Lock writing(writing_);
    close_writer();
  }
  if (topic_.entity > 0) dds_delete(topic_.entity);
}

std::string RosGraph::node_of(const Guid& endpoint) const {
  const Lock lock(mutex_);
  return std::string(others_.node_of(endpoint));
}

bool RosGraph::is_divided() const {
  const Lock lock(mutex_);
  return others_.uses(GuidBytes::as_of_iron) && others_.uses(GuidBytes::before_iron);
}

std::optional<GuidBytes> RosGraph::guid_bytes() const {
  const bool later = others_.uses(GuidBytes::as_of_iron), before = others_.uses(GuidBytes::before_iron);
  if (later && before) return std::nullopt;
  if (!later && !before) return expected_;
  return later ? GuidBytes::as_of_iron : GuidBytes::before_iron;
}

/// Writes the nodes of this process if the nodes or the size of GUIDs have changed. The writer retains the
/// last message for nodes that join later. So the writer is closed if the size is not known any more.
void RosGraph::write() {
  const Lock writing(writing_);
  ParticipantEntities entities{.participant = guid_of(participant_)};
  std::optional<GuidBytes> size;
  {
    const Lock lock(mutex_);
    size = guid_bytes();
    for (const LocalNode* node : nodes_)
      if (!node->shown_.name.empty()) entities.nodes.push_back(node->shown_);
  }
  if (!size) return close_writer();
  std::vector<std::byte> body = encode_entities(entities, *size);
  if (body == written_ || (writer_ <= 0 && entities.nodes.empty()) || !open_writer()) return;
  const SampleHandle sample = raw_body(body, reading_);
  if (!sample) return;
  sample->source_stamp_ns = realtime_ns();
  if (dds_forwardcdr(writer_, raw_sample(topic_.type, sample, 0)) == DDS_RETCODE_OK)
    written_ = std::move(body);
}

/// Returns false if the writer could not be opened. The next call tries again.
bool RosGraph::open_writer() {
  if (writer_ > 0) return true;
  const DdsQos qos = qos_of_graph();
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 1);
  dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, 1, DDS_LENGTH_UNLIMITED,
                              DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  dds_qset_writer_data_lifecycle(qos.get(), false);
  writer_ = dds_create_writer(participant_, topic_.entity, qos.get(), nullptr);
  return writer_ > 0;
}

void RosGraph::close_writer() {
  if (writer_ > 0) dds_delete(writer_);
  writer_ = 0;
  written_.clear();
}

void RosGraph::take(dds_entity_t reader) {
  bool is_news = false;
  const Lock lock(mutex_);
  ddsi_serdata* data = nullptr;
  dds_sample_info_t info{};
  while (dds_takecdr(reader, &data, 1, &info, DDS_ANY_STATE) > 0) {
    if (info.valid_data) is_news |= note(reader, info.publication_handle, data);
    ddsi_serdata_unref(data);
  }
  if (is_news) notify();
}

/// Returns true if the known nodes have changed. Messages of other processes of SFT are ignored: their size
/// depends on the messages of ROS 2, so two processes of SFT would keep each other's size for ever.
bool RosGraph::note(dds_entity_t reader, dds_instance_handle_t writer, const ddsi_serdata* data) {
  const RawArrival arrival = raw_arrival(data);
  if (!arrival.sample) return false;
  const detail::SampleState state = state_of(*arrival.sample, 0);
  const std::optional<ReceivedEntities> received = decode_entities({state.body, state.body_bytes});
  if (!received) return false;
  dds_builtintopic_endpoint_t* const announced = dds_get_matched_publication_data(reader, writer);
  if (announced == nullptr) return false;
  const bool is_ours = is_endpoint_of_sft(announced->qos);
  const Guid participant = guid_of(announced->participant_key);
  dds_builtintopic_free_endpoint(announced);
  return !is_ours && others_.note(writer, participant, *received);
}

void RosGraph::forget(dds_instance_handle_t writer) {
  const Lock lock(mutex_);
  if (others_.forget(writer)) notify();
}

void RosGraph::notify() {
  for (LocalNode* node : nodes_)
    if (!std::exchange(node->has_news_, true) && node->changed_) node->changed_();
}

RosGraph::LocalNode::LocalNode(RosGraph& graph, std::function<void()> changed)
    : graph_(graph), changed_(std::move(changed)) {
  const Lock lock(graph_.mutex_);
  graph_.nodes_.insert(this);
}

RosGraph::LocalNode::~LocalNode() {
  {
    const Lock lock(graph_.mutex_);
    graph_.nodes_.erase(this);
  }
  graph_.write();
}

void RosGraph::LocalNode::show(ParticipantEntities::Node node) {
  {
    const Lock lock(graph_.mutex_);
    shown_ = std::move(node);
  }
  graph_.write();
}

bool RosGraph::LocalNode::take_news() {
  const Lock lock(graph_.mutex_);
  return std::exchange(has_news_, false);
}

}  // namespace sft::core
