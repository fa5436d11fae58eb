// Translates the definitions of a file to the model, from which the emitters write a header.
#pragma once

#include <deque>
#include <filesystem>
#include <string>
#include <vector>

#include "from_msg/definition.h"
#include "model.h"

namespace sft::msg {

/// The place of a file, and the files on which it depends.
struct Files {
  std::filesystem::path root;  ///< the file is <root>/<package>/msg/<Name>.msg, or .../srv/<Name>.srv
  std::vector<std::filesystem::path> nested;
};

/// A file of the model. The object owns everything to which the model points.
class ModelOf {
 public:
  /// Makes the model of a message.
  ModelOf(const Definition& definition, const Files& files);
  /// Makes the model of a service from the definitions that parse_service() returns.
  ModelOf(const TypeName& service, const std::vector<Definition>& definitions, const Files& files);
  ModelOf(const ModelOf&) = delete;
  ModelOf& operator=(const ModelOf&) = delete;

  /// Returns the model. It is valid as long as this object. The caller must not pass it to sft_file_free().
  const sft_file& file() const { return file_; }

 private:
  void add(const Definition& definition, const Files& files);
  void finish();
  void add_constants(const Definition& definition);
  void add_struct(const Definition& definition);
  sft_member member_of(const Field& field);
  sft_type type_of(const Type& type);
  sft_value value_of(const Value& value);
  const char* keep(std::string text) { return texts_.emplace_back(std::move(text)).c_str(); }

  std::deque<std::string> texts_;
  std::deque<std::vector<sft_value>> initials_;
  std::vector<const char*> includes_;
  std::vector<const char*> sources_;
  std::deque<std::vector<sft_member>> members_;  // the members of each struct
  std::vector<sft_declaration> declarations_;
  sft_file file_{};
};

}  // namespace sft::msg
