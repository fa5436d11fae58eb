// What one .idl or .msg file declares, as the emitters need it: names resolved, typedefs seen through, and
// nothing left that no C++ is emitted for. Plain C, because idlc's headers, from which the IDL reader fills
// it, cannot be included in C++.
//
// Who fills it owns what it points to: text of the IDL reader is in idlc's tree, its arrays are freed with
// sft_file_free(). Scoped names begin with "::".
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { SFT_DIMENSIONS_MAX = 8 };

// The kinds of sft::detail::Kind; primitives come first.
enum sft_kind {
  SFT_BOOLEAN,
  SFT_OCTET,
  SFT_CHARACTER,
  SFT_INT8,
  SFT_UINT8,
  SFT_INT16,
  SFT_UINT16,
  SFT_INT32,
  SFT_UINT32,
  SFT_INT64,
  SFT_UINT64,
  SFT_FLOAT32,
  SFT_FLOAT64,
  SFT_STRING,
  SFT_STRUCTURE
};

// A single value, an array (dimension_count > 0) or a sequence of elements.
struct sft_type {
  enum sft_kind kind;     ///< of one element; of an enumeration or bitmask, the integer that carries it
  const char* name;       ///< scoped, of the element's struct, enumeration or bitmask; null otherwise
  uint32_t string_bound;  ///< most characters of each string; 0: unbounded
  bool is_sequence;
  uint32_t bound;  ///< most elements of the sequence; 0: unbounded
  size_t dimension_count;
  uint32_t dimensions[SFT_DIMENSIONS_MAX];  ///< outermost first
};

// Which alternative holds the value follows from the type it belongs to.
struct sft_value {
  bool is_set;
  union {
    bool boolean;
    char character;
    int64_t integer;   ///< of int8 to int64
    uint64_t natural;  ///< of octet, uint8 to uint64, a bitmask
    double real;
    const char* text;  ///< of a string; of an enumeration, the enumerator's identifier
  };
};

struct sft_member {
  const char* name;
  struct sft_type type;
  struct sft_value initial;            ///< of a single value; unset: value-initialized
  struct sft_value* initial_elements;  ///< of an array, all of them, the last index fastest; of a sequence
  size_t initial_element_count;        ///< 0: value-initialized
  bool is_key;
  const char* unit;  ///< null: none given
};

// Or a flag of a bitmask: the value is then its bit.
struct sft_enumerator {
  const char* name;
  uint64_t value;
};

enum sft_declaration_kind { SFT_CONSTANT, SFT_ALIAS, SFT_ENUMERATION, SFT_BITMASK, SFT_STRUCT };

// Which members count follows from the kind.
struct sft_declaration {
  enum sft_declaration_kind kind;
  const char* name;        ///< scoped
  struct sft_type type;    ///< of a constant, an alias; of an enumeration or bitmask, what carries it
  struct sft_value value;  ///< of a constant
  struct sft_enumerator* enumerators;
  size_t enumerator_count;
  struct sft_member* members;
  size_t member_count;
};

// All paths are absolute, and of the originals where files are copies.
struct sft_file {
  const char* copies;  ///< "", or below which idlc was given copies: that of /a/b.idl is <copies>/a/b.idl
  const char* path;
  const char** includes;  ///< files that it includes itself
  size_t include_count;
  const char** sources;  ///< it, and all that it includes directly or not
  size_t source_count;
  struct sft_declaration* declarations;  ///< its own, in their order
  size_t declaration_count;
  char** texts;  ///< that the IDL reader made itself
  size_t text_count;
};

void sft_file_free(struct sft_file* file);

#ifdef __cplusplus
}
#endif
