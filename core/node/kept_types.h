// Types that are known only at run time. They are kept as long as the node lives, because publishers, their
// jobs and their histories refer to them. Any thread may use it.
#pragma once

#include <map>
#include <string>

#include "core/sync/mutex.h"
#include "sft/dynamic_type.h"

namespace sft::core {

class KeptTypes {
 public:
  /// Keeps the type, and returns a reference to the kept type. For types with equal descriptions the same
  /// reference is returned.
  const TypeSupport& keep(const DynamicType& type) {
    const std::span<const std::byte> bytes = type.description();
    const std::string description(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const Lock lock(mutex_);
    return by_description_.try_emplace(description, type).first->second.support();
  }

 private:
  Mutex mutex_;
  std::map<std::string, DynamicType> by_description_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::core
