// Finds the message type that a publisher is to use.
#pragma once

#include <string>

#include "tools/sft/session.h"

namespace sft::tool {

/// Returns the type that the user names (PubOptions::type). Looks for a name in the directories of the
/// session (CommonOptions::includes), in the messages that are installed with SFT, and then, for the timeout
/// of the session, among the types that nodes announce. Errc::unavailable if no place has it.
Result<DynamicType> find_message_type(const std::string& type, const std::string& topic, Session& session);

}  // namespace sft::tool
