// The DDS reader by which one selection of a subscriber receives the samples of unmodified writers. While
// there is no such writer, the reader only shows nodes of ROS 2 that the subscriber exists. Samples that
// other endpoints of SFT send by DDS are dropped, because they also arrive by SFT.
#pragma once

#include <dds/dds.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "core/seam/vanilla_port.h"
#include "core/sync/mutex.h"
#include "core/vanilla/raw_sample.h"
#include "core/vanilla/vanilla_domain.h"
#include "core/vanilla/vanilla_matching.h"
#include "sft/qos.h"
#include "sft/result.h"

namespace sft::core {

class VanillaReader {
 public:
  /// The functions in this struct are called by threads of Cyclone, and must return at once.
  struct Spec {
    EndpointId id = 0;     ///< the id of the subscriber's selection
    std::string topic{};   ///< the name in SFT
    DdsNames names{};      ///< the names of topic and type
    RawReading reading{};  ///< the type and the memory for samples
    Qos qos{};             ///< the QoS that the subscriber requests
    /// False: the reader is in a separate partition, in which there are no writers, and reads nothing.
    bool hears = true;
    /// Called for each sample, in the order in which samples arrive, and never at the same time by two
    /// threads. Returns true if the subscriber has to be woken.
    std::function<bool(const VanillaArrival&)> arrived{};
    std::function<void()> wake{};
    /// Called when writers have begun or ceased to match, or when a sample could not be read for a new
    /// reason.
    std::function<void()> changed{};
  };
  static Result<std::unique_ptr<VanillaReader>> open(std::shared_ptr<VanillaDomain> domain, Spec spec);
  /// Waits until none of the functions runs any more.
  ~VanillaReader();
  VanillaReader(const VanillaReader&) = delete;
  VanillaReader& operator=(const VanillaReader&) = delete;

  const std::shared_ptr<VanillaDomain>& domain() const { return domain_; }
  bool hears() const { return spec_.hears; }
  Guid guid() const { return guid_of(reader_); }
  /// Returns true if this writer matches at present. Any thread may call this.
  bool is_matched(EndpointId writer) const;
  /// Returns the reasons for which samples could not be read so far. Any thread may call this.
  std::set<RawFault> faults() const;

 private:
  struct Writer {
    EndpointId id = 0;
    bool is_heard = false;  ///< false: the writer belongs to SFT, or does not match the subscriber
    bool is_matched = true;
  };
  /// The maximum number of departed writers that are remembered, since their last samples may still arrive
  static constexpr std::size_t departed_max = 64;

  VanillaReader(std::shared_ptr<VanillaDomain> domain, Spec spec);
  Result<void> open();
  void match(dds_entity_t reader, dds_instance_handle_t writer);
  void catch_up();
  void take(dds_entity_t reader);
  bool take_some(dds_entity_t reader, bool& some_arrived) SFT_REQUIRES(taking_);
  bool deliver(const ddsi_serdata* data, const Writer& writer, std::int64_t source_stamp_ns);
  Writer writer_of(dds_entity_t reader, dds_instance_handle_t writer);
  Writer look_up(dds_entity_t reader, dds_instance_handle_t writer) const;

  const std::shared_ptr<VanillaDomain> domain_;
  const Spec spec_;
  const std::string type_name_, type_hash_;
  RawTopic topic_;
  dds_entity_t reader_ = 0;
  /// Keeps the order of samples if two threads take them at the same time
  Mutex taking_ SFT_ACQUIRED_BEFORE(mutex_);
  mutable Mutex mutex_;
  std::map<dds_instance_handle_t, Writer> writers_ SFT_GUARDED_BY(mutex_);
  std::set<RawFault> faults_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::core
