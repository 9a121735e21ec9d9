// What a message consists of, made from its `fields`: as .msg text for recordings, and as the type
// description of REP-2011 for type hashes. Any thread that may allocate.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "bridges/ros2/messages/cdr.hpp"
#include "bridges/ros2/messages/messages.hpp"

namespace slipd::ros2 {

// Numbers of type_description_interfaces/msg/FieldType.
enum class TypeId : std::uint8_t {
  nested = 1,
  int8 = 2,
  uint8 = 3,
  int16 = 4,
  uint16 = 5,
  int32 = 6,
  uint32 = 7,
  int64 = 8,
  uint64 = 9,
  float32 = 10,
  float64 = 11,
  boolean = 15,
  byte = 16,
  string = 17,
  bounded_string = 21
};
// What is added to a number of TypeId for an array of fixed length, and for a sequence without bound.
inline constexpr int kArrayOffset = 48;
inline constexpr int kSequenceOffset = 144;

struct Field {
  std::string name;
  // A number of TypeId, plus an offset.
  int type_id = 0;
  // Elements of an array; else 0.
  std::size_t capacity = 0;
  // Most characters of a bounded string; else 0.
  std::size_t string_capacity = 0;
  // "std_msgs/msg/Header" of a field that is a message, or has messages; else empty.
  std::string nested;
  // As a .msg file spells it: "float64", "std_msgs/Header[]".
  std::string type_text;
};

struct Definition {
  // "std_msgs/msg/Header"
  std::string name;
  // Lines of constants of the .msg file; may be empty.
  std::string constants;
  std::vector<Field> fields;
};

// "std_msgs/msg/Header" as a .msg file spells it: "std_msgs/Header".
std::string short_name(std::string_view name);
// "std_msgs/msg/Header" as DDS has it: "std_msgs::msg::dds_::Header_".
std::string dds_name(std::string_view name);

// The .msg text of the first definition, and behind it those of all others, as MCAP's schema encoding
// `ros2msg` has it.
std::string msg_text(const std::vector<Definition>& definitions);
// The .msg text of one definition alone.
std::string msg_text(const Definition& definition);
// The JSON text whose SHA-256 is the type hash: REP-2011; `definitions` as definitions_of returns them.
std::string type_description(const std::vector<Definition>& definitions);

namespace detail {

template <class T>
struct Plain;  // TypeId and spelling of a type that is no message
template <TypeId ID>
struct PlainId {
  static constexpr TypeId kId = ID;
};
// clang-format off
template <> struct Plain<bool> : PlainId<TypeId::boolean> { static constexpr const char* kText = "bool"; };
template <> struct Plain<Byte> : PlainId<TypeId::byte> { static constexpr const char* kText = "byte"; };
template <> struct Plain<std::uint8_t> : PlainId<TypeId::uint8> { static constexpr const char* kText = "uint8"; };
template <> struct Plain<std::int32_t> : PlainId<TypeId::int32> { static constexpr const char* kText = "int32"; };
template <> struct Plain<std::uint32_t> : PlainId<TypeId::uint32> { static constexpr const char* kText = "uint32"; };
template <> struct Plain<std::uint64_t> : PlainId<TypeId::uint64> { static constexpr const char* kText = "uint64"; };
template <> struct Plain<float> : PlainId<TypeId::float32> { static constexpr const char* kText = "float32"; };
template <> struct Plain<double> : PlainId<TypeId::float64> { static constexpr const char* kText = "float64"; };
template <> struct Plain<std::string> : PlainId<TypeId::string> { static constexpr const char* kText = "string"; };
// clang-format on

class Describer {
 public:
  explicit Describer(std::vector<Definition>& all) : all_(all) {}

  // Adds the definitions of T and of what it contains, unless they are there.
  template <Message T>
  void add() {
    const auto known = [](const Definition& d) { return d.name == T::kName; };
    if (std::any_of(all_.begin(), all_.end(), known)) return;
    const std::size_t place = all_.size();
    all_.push_back({.name = std::string(T::kName), .constants = {}, .fields = {}});
    if constexpr (requires { T::kConstants; }) all_[place].constants = T::kConstants;
    const T message;
    T::fields(message, [&]<class F>(std::string_view name, const F&) {
      Field field = field_of<F>();
      field.name = name;
      all_[place].fields.push_back(field);
    });
  }

 private:
  template <class F>
  struct Tag {};

  template <class F>
  Field field_of() {
    return field_of(Tag<F>());
  }
  template <class F>
  Field field_of(Tag<F> /*type*/) {
    Field field;
    if constexpr (Message<F>) {
      add<F>();
      field.type_id = static_cast<int>(TypeId::nested);
      field.nested = F::kName;
      field.type_text = short_name(F::kName);
    } else {
      field.type_id = static_cast<int>(Plain<F>::kId);
      field.type_text = Plain<F>::kText;
    }
    return field;
  }
  template <std::size_t MOST>
  Field field_of(Tag<BoundedString<MOST>> /*type*/) {
    Field field;
    field.type_id = static_cast<int>(TypeId::bounded_string);
    field.string_capacity = MOST;
    field.type_text = "string<=" + std::to_string(MOST);
    return field;
  }
  template <class E>
  Field field_of(Tag<std::vector<E>> /*type*/) {
    Field field = field_of<E>();
    field.type_id += kSequenceOffset;
    field.type_text += "[]";
    return field;
  }
  template <class E, std::size_t N>
  Field field_of(Tag<std::array<E, N>> /*type*/) {
    Field field = field_of<E>();
    field.type_id += kArrayOffset;
    field.capacity = N;
    field.type_text += "[" + std::to_string(N) + "]";
    return field;
  }

  std::vector<Definition>& all_;
};

}  // namespace detail

// T's definition, and behind it those of all messages that it contains.
template <Message T>
std::vector<Definition> definitions_of() {
  std::vector<Definition> all;
  detail::Describer(all).add<T>();
  return all;
}

}  // namespace slipd::ros2
