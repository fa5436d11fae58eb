// Finds the message type for a publisher.
#pragma once

#include <string>

#include "tools/sft/session.h"

namespace sft::tool {

/// Returns the type that the user names (PubOptions::type). A name is searched for in the directories of the
/// session (CommonOptions::includes), in the messages that are installed with SFT, and then, for the timeout
/// of the session, among the types that nodes announce. The error is Errc::unavailable if the type is found
/// in none of these places.
Result<DynamicType> find_message_type(const std::string& type, const std::string& topic, Session& session);

}  // namespace sft::tool
