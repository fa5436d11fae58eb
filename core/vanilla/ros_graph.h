// The nodes of this process in the graph of ROS 2, which `ros2 node list` and `ros2 topic info` show, and
// the names of the other nodes in the graph. Processes announce their nodes on the topic
// "ros_discovery_info", in messages with GUIDs of one of two sizes (participant_entities.h). A message of
// the wrong size can end the nodes that read it. So nothing is written before the size is known: the size
// of the received messages, or, if there are none, the size for the distribution that the environment
// names. While messages of both sizes arrive, nothing is written.
#pragma once

#include <dds/dds.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/sync/mutex.h"
#include "core/vanilla/participant_entities.h"
#include "core/vanilla/raw_sample.h"
#include "core/vanilla/ros_nodes.h"

namespace sft::core {

class RosGraph {
 public:
  /// `expected` is the size for the distribution of ROS 2 that the environment names.
  RosGraph(dds_entity_t participant, std::optional<GuidBytes> expected);
  /// Waits until no listener runs any more. Must be called before the participant is deleted.
  ~RosGraph();
  RosGraph(const RosGraph&) = delete;
  RosGraph& operator=(const RosGraph&) = delete;

  /// Returns the name of the ROS 2 node to which this reader or writer belongs, such as "/left/camera". The
  /// result is empty if the node is unknown. Any thread may call this.
  std::string node_of(const Guid& endpoint) const;
  /// Returns true if present nodes have sent messages of both sizes. Any thread may call this.
  bool is_divided() const;

  /// A node of this process. It is in the graph after the first call of show(). It must be used by only one
  /// thread at a time.
  class LocalNode {
   public:
    /// `changed` is called by threads of Cyclone when names of nodes or the size of GUIDs have changed. It
    /// must return at once.
    LocalNode(RosGraph& graph, std::function<void()> changed);
    ~LocalNode();
    LocalNode(const LocalNode&) = delete;
    LocalNode& operator=(const LocalNode&) = delete;

    /// Announces the node, with its readers and writers, to other processes. Must also be called after
    /// `changed` was called.
    void show(ParticipantEntities::Node node);
    /// Returns true if `changed` was called since the last call of this function.
    bool take_news();

   private:
    friend class RosGraph;
    RosGraph& graph_;
    const std::function<void()> changed_;
    // The following members are guarded by the mutex of the graph.
    ParticipantEntities::Node shown_;  ///< has no name until show() is called
    bool has_news_ = false;
  };

 private:
  std::optional<GuidBytes> guid_bytes() const SFT_REQUIRES(mutex_);
  void write();
  bool open_writer() SFT_REQUIRES(writing_);
  void close_writer() SFT_REQUIRES(writing_);
  void take(dds_entity_t reader);
  bool note(dds_entity_t reader, dds_instance_handle_t writer, const ddsi_serdata* data) SFT_REQUIRES(mutex_);
  void forget(dds_instance_handle_t writer);
  void notify() SFT_REQUIRES(mutex_);

  const dds_entity_t participant_;
  const std::optional<GuidBytes> expected_;
  const RawReading reading_;
  const RawTopic topic_;
  dds_entity_t reader_ = 0;
  /// Keeps the order of messages if two nodes write at the same time
  Mutex writing_ SFT_ACQUIRED_BEFORE(mutex_);
  dds_entity_t writer_ SFT_GUARDED_BY(writing_) = 0;
  std::vector<std::byte> written_ SFT_GUARDED_BY(writing_);  ///< the last message
  mutable Mutex mutex_;
  RosNodes others_ SFT_GUARDED_BY(mutex_);
  std::set<LocalNode*> nodes_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::core
