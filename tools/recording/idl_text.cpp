#include "tools/recording/idl_text.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <utility>
#include <vector>

namespace sft::recording {

namespace {

/// Splits IDL into names (with their "::"), numbers, texts and signs.
std::vector<std::string> words_of(std::string_view text) {
  std::vector<std::string> words;
  const auto is_name = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == ':';
  };
  for (std::size_t at = 0; at < text.size();) {
    const std::string_view rest = text.substr(at);
    std::size_t length = 1;
    const bool skips_line = rest.starts_with("//") || rest.starts_with('#') || rest.starts_with("IDL: ") ||
                            rest.starts_with("====");
    if (skips_line) {
      length = std::min(rest.find('\n'), rest.size());
    } else if (rest.starts_with("/*")) {
      length = std::min(rest.find("*/") == rest.npos ? rest.size() : rest.find("*/") + 2, rest.size());
    } else if (rest.front() == '"') {
      while (length < rest.size() && rest[length] != '"') length += rest[length] == '\\' ? 2 : 1;
      length = std::min(length + 1, rest.size());
      words.emplace_back("\"");
    } else if (is_name(rest.front())) {
      while (length < rest.size() && is_name(rest[length])) ++length;
      words.emplace_back(rest.substr(0, length));
    } else if (std::isspace(static_cast<unsigned char>(rest.front())) == 0) {
      words.emplace_back(rest.substr(0, 1));
    }
    at += length;
  }
  return words;
}

class IdlReader {
 public:
  explicit IdlReader(std::string_view text) : words_(words_of(text)) {}

  Result<std::string> read(std::string_view name) {
    while (at_ < words_.size() && fault_.empty()) definition({});
    if (!fault_.empty()) return fail(Errc::malformed, "the IDL of " + std::string(name) + ": " + fault_);
    const std::string root =
        std::string(name.substr(0, name.find('/'))) + "/" + std::string(name.substr(name.rfind('/') + 1));
    const auto found = messages_.find(root);
    if (found == messages_.end())
      return fail(Errc::malformed, "the IDL does not define " + std::string(name));
    std::string text = found->second;
    for (const auto& [other, lines] : messages_) {
      if (other != root) text += std::string(80, '=') + "\nMSG: " + other + "\n" + lines;
    }
    return text;
  }

 private:
  static constexpr std::size_t depth_most = 16;
  static constexpr std::size_t type_most = 512;

  std::string next() { return at_ < words_.size() ? words_[at_++] : std::string(); }
  bool take(std::string_view word) {
    const bool is_there = at_ < words_.size() && words_[at_] == word;
    at_ += is_there ? 1 : 0;
    return is_there;
  }
  void expect(std::string_view word) {
    if (!take(word)) refuse("'" + std::string(word) + "' was expected");
  }
  void refuse(const std::string& what) {
    if (fault_.empty())
      fault_ = what + (at_ < words_.size() ? " at '" + words_[at_].substr(0, 40) + "'" : " at its end");
    at_ = words_.size();
  }
  void skip_until(std::string_view word) {
    while (at_ < words_.size() && !take(word)) ++at_;
  }
  void skip_annotations() {
    while (take("@")) {
      next();
      if (!take("(")) continue;
      for (int depth = 1; depth > 0 && at_ < words_.size();) {
        const std::string word = next();
        depth += word == "(" ? 1 : word == ")" ? -1 : 0;
      }
    }
  }

  void definition(const std::vector<std::string>& modules) {
    skip_annotations();
    if (at_ >= words_.size()) return;
    if (modules.size() > depth_most) return refuse("modules are nested too deeply");
    if (take("module")) {
      std::vector<std::string> inner = modules;
      inner.push_back(next());
      expect("{");
      while (at_ < words_.size() && !take("}")) definition(inner);
      take(";");
    } else if (take("const")) {
      skip_until(";");
    } else if (take("typedef")) {
      std::string type = type_name();
      const std::string alias = next();
      end_of_type(type);
      aliases_[alias] = type;
    } else if (take("struct")) {
      structure(modules);
    } else {
      refuse("this is not known in messages");
    }
  }

  /// Reads the length of an array after a name, if there is one, and the semicolon.
  void end_of_type(std::string& type) {
    if (take("[")) type += "[" + next() + "]", expect("]");
    expect(";");
    // The limit is needed because aliases of aliases could use up all memory.
    if (type.size() > type_most) refuse("a type has more than " + std::to_string(type_most) + " characters");
  }

  void structure(const std::vector<std::string>& modules) {
    const std::string name = (modules.empty() ? std::string() : modules.front()) + "/" + next();
    std::string lines;
    expect("{");
    while (at_ < words_.size() && !take("}")) {
      skip_annotations();
      if (take("}")) break;
      std::string type = type_name();
      const std::string member = next();
      end_of_type(type);
      // ROS 2 writes this member into the IDL of a message without fields. The .msg file has no member.
      if (member != "structure_needs_at_least_one_member") lines += type + " " + member + "\n";
    }
    take(";");
    messages_[name] = lines;
  }

  enum class Element : bool { no, yes };
  std::string type_name(Element is_element = Element::no) {
    if (take("sequence")) {
      if (is_element == Element::yes) return refuse("messages have no sequences of sequences"), "";
      expect("<");
      const std::string element = type_name(Element::yes);
      const std::string bound = take(",") ? "<=" + next() : "";
      expect(">");
      return element + "[" + bound + "]";
    }
    const std::string word = next();
    if (word == "string" || word == "wstring") {
      if (!take("<")) return word;
      const std::string bound = next();
      expect(">");
      return word + "<=" + bound;
    }
    if (word == "unsigned")
      return take("short") ? "uint16" : (expect("long"), take("long") ? "uint64" : "uint32");
    if (word == "long") return take("double") ? "long double" : take("long") ? "int64" : "int32";
    static const std::map<std::string, std::string> names{{"float", "float32"},
                                                          {"double", "float64"},
                                                          {"boolean", "bool"},
                                                          {"octet", "byte"},
                                                          {"short", "int16"}};
    if (const auto known = names.find(word); known != names.end()) return known->second;
    if (const auto alias = aliases_.find(word.substr(word.rfind(':') + 1)); alias != aliases_.end())
      return alias->second;
    const std::size_t first = word.find("::"), last = word.rfind("::");
    return first == word.npos ? word : word.substr(0, first) + "/" + word.substr(last + 2);
  }

  std::vector<std::string> words_;
  std::size_t at_ = 0;
  std::map<std::string, std::string> aliases_;
  /// The lines of each message, by a name such as "my_msgs/Status"
  std::map<std::string, std::string> messages_;
  std::string fault_;
};

}  // namespace

Result<std::string> msg_of_idl(std::string_view name, std::string_view text) {
  return IdlReader(text).read(name);
}

}  // namespace sft::recording
