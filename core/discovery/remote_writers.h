// The participants behind the writers of a control topic of which something has come. One thread at a time.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>

#include "core/discovery/participants.h"

namespace sft::core {

class RemoteWriters {
 public:
  using Handle = std::uint64_t;  ///< Cyclone's number of a writer

  struct Writer {
    Participants::Guid participant{};
    std::chrono::milliseconds lease{};
  };
  std::optional<Writer> writer(Handle handle) const {
    const auto writer = writers_.find(handle);
    return writer == writers_.end() ? std::nullopt : std::optional(writer->second);
  }
  void enter(Handle handle, const Writer& writer) {
    if (writers_.size() == writers_max) writers_.clear();  // Cyclone is asked for them again
    writers_.emplace(handle, writer);
  }
  void forget(const Participants::Guid& participant) {
    std::erase_if(writers_, [&](const auto& writer) { return writer.second.participant == participant; });
  }

 private:
  static constexpr std::size_t writers_max = 4096;

  std::map<Handle, Writer> writers_;
};

}  // namespace sft::core
