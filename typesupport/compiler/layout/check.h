// Checks layout rules for the reader of IDL, which is written in C because idlc's headers are not C++.
#pragma once

#include "model.h"

#ifdef __cplusplus
extern "C" {
#endif

enum sft_shape { SFT_SINGLE, SFT_ARRAY, SFT_SEQUENCE };

/// The properties of a struct's member that rules use.
struct sft_seen {
  const char* name;  ///< the name of the member; null: there is no member with this index
  enum sft_kind kind;
  enum sft_shape shape;
  const void* type;  ///< the type of the member if it is a structure
};

/// Returns the i-th member of a struct.
typedef struct sft_seen (*sft_see)(const void* type, size_t i);

/// The rule of the i-th member of the struct, in its original spelling.
struct sft_rule {
  size_t member;
  const char* text;
};

/// A mistake in a rule. This struct holds its text.
struct sft_rule_fault {
  size_t rule;  ///< the index of the rule in the list
  size_t at;    ///< the position in the text of the rule, in bytes
  char text[400];
};

/// Returns the canonical spelling of a rule, which the caller frees. If the rule is wrong, returns null and
/// describes the mistake in `fault`.
char* sft_layout_text(const char* text, struct sft_rule_fault* fault);

/// Checks the rules of a struct. Returns false if one of them does not suit the struct. REQUIRES:
/// sft_layout_text() has accepted each rule.
bool sft_check_layouts(sft_see see, const void* type, const struct sft_rule* rules, size_t count,
                       struct sft_rule_fault* fault);

#ifdef __cplusplus
}
#endif
