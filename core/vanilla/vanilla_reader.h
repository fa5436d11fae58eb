// The DDS reader by which one selection of a subscriber hears unmodified writers of its topic, or by which
// nodes of ROS 2 see that the subscriber is there, before such a writer is. What other endpoints of SFT send
// by DDS is dropped, since it comes by SFT, too.
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
  /// Functions are called by threads of Cyclone, and must return at once.
  struct Spec {
    EndpointId id = 0;     ///< the subscriber's selection
    std::string topic{};   ///< the name in SFT
    DdsNames names{};      ///< the names of topic and type
    RawReading reading{};  ///< what it needs to read samples
    Qos qos{};             ///< the QoS that the subscriber requests
    /// False: the reader is in a partition of its own, in which there are no writers, and reads nothing.
    bool hears = true;
    /// Called for one sample at a time, in the order in which they arrive. Returns true if the subscriber has
    /// to be woken.
    std::function<bool(const VanillaArrival&)> arrived{};
    std::function<void()> wake{};
    /// Called when writers have begun or ceased to match, or a sample could not be read for a new reason.
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
  /// Returns true if that writer matches at present. Any thread.
  bool is_matched(EndpointId writer) const;
  /// Returns the reasons for which samples could not be read so far. Any thread.
  std::set<RawFault> faults() const;

 private:
  struct Writer {
    EndpointId id = 0;
    bool is_heard = false;  ///< false: it is one of SFT, or does not fit the subscriber
    bool is_matched = true;
  };
  static constexpr std::size_t departed_max = 64;  ///< their last samples may still arrive

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
  Mutex taking_ SFT_ACQUIRED_BEFORE(mutex_);  ///< keeps the order of samples while two threads take them
  mutable Mutex mutex_;
  std::map<dds_instance_handle_t, Writer> writers_ SFT_GUARDED_BY(mutex_);
  std::set<RawFault> faults_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::core
