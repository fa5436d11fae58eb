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
    EndpointId id = 0;                  ///< the id of the publisher
    std::string topic{};                ///< the name in SFT
    DdsNames names{};                   ///< the names of topic and type
    const TypeSupport* type = nullptr;  ///< must outlive the writer
    Qos qos{};                          ///< the QoS of the publisher
    std::size_t max_sample_bytes = 0;
    /// Called by a thread of Cyclone when readers have appeared or departed. Must return at once.
    std::function<void()> readers_changed{};
  };
  static Result<std::shared_ptr<VanillaWriter>> open(std::shared_ptr<VanillaDomain> domain, Spec spec);
  /// Waits until `readers_changed` does not run any more. Cyclone releases the samples soon afterwards.
  ~VanillaWriter();
  VanillaWriter(const VanillaWriter&) = delete;
  VanillaWriter& operator=(const VanillaWriter&) = delete;

  const std::shared_ptr<VanillaDomain>& domain() const { return domain_; }
  Guid guid() const { return guid_of(writer_); }
  /// Returns the number of matching readers that do not belong to SFT. Must be called by only one thread at
  /// a time.
  std::size_t readers() const;
  /// Returns sentences about problems with readers of the topic, each sentence once: the reason why a
  /// reader does not match, or that it misreads its samples. Must be called by only one thread at a time.
  std::set<std::string> complaints() const;
  /// Waits until all matching reliable readers have acknowledged all samples that were written before the
  /// call, but at most for the time `within`. Returns false if a reader has not acknowledged them.
  bool is_acknowledged(std::chrono::nanoseconds within) const;
  /// Announces whether readers acknowledge their samples. Must be called by only one thread at a time.
  void announce_answers(bool is_answered) const;
  /// Sends the sample on the calling thread, without waiting for readers. Returns false if Cyclone refuses
  /// the sample. Must be called by only one thread at a time.
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
