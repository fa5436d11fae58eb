// The DDS writer by which one publisher serves unmodified readers of its topic.
#pragma once

#include <dds/dds.h>

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <set>
#include <string>

#include "core/seam/sample_buffer.h"
#include "core/vanilla/raw_sample.h"
#include "core/vanilla/vanilla_domain.h"
#include "sft/qos.h"
#include "sft/result.h"
#include "sft/type_support.h"

namespace sft::core {

class VanillaWriter {
 public:
  struct Spec {
    EndpointId id = 0;                  ///< the publisher
    std::string topic{};                ///< the name in SFT
    DdsNames names{};                   ///< the names of topic and type
    const TypeSupport* type = nullptr;  ///< outlives the writer
    Qos qos{};                          ///< QoS of the publisher
    std::size_t max_sample_bytes = 0;
    /// Called by a thread of Cyclone when readers have come or gone. Must return at once.
    std::function<void()> readers_changed{};
  };
  static Result<std::shared_ptr<VanillaWriter>> open(std::shared_ptr<VanillaDomain> domain, Spec spec);
  /// Waits until `readers_changed` does not run any more. Cyclone releases the samples soon after.
  ~VanillaWriter();
  VanillaWriter(const VanillaWriter&) = delete;
  VanillaWriter& operator=(const VanillaWriter&) = delete;

  const std::shared_ptr<VanillaDomain>& domain() const { return domain_; }
  Guid guid() const { return guid_of(writer_); }
  /// Returns the number of matching readers that are not SFT's. One thread at a time.
  std::size_t readers() const;
  /// Returns what is wrong with readers of the topic, each sentence once: why they do not match, or that they
  /// misread what they get. One thread at a time.
  std::set<std::string> complaints() const;
  /// Waits at most that time until all matching reliable readers have acknowledged what was written before
  /// the call. Returns false if one of them has not.
  bool is_acknowledged(std::chrono::nanoseconds within) const;
  /// Announces whether readers acknowledge what they are sent. One thread at a time.
  void announce_answers(bool is_answered) const;
  /// Sends the sample on the calling thread, without waiting for readers. Returns false if Cyclone refuses
  /// the sample. One thread at a time.
  bool write(const SampleHandle& sample) noexcept;

 private:
  VanillaWriter(std::shared_ptr<VanillaDomain> domain, Spec spec);
  Result<void> open();

  const std::shared_ptr<VanillaDomain> domain_;
  const Spec spec_;
  const std::string type_name_, type_hash_;
  RawTopic topic_;
  dds_entity_t writer_ = 0;
};

}  // namespace sft::core
