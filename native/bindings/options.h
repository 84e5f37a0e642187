#pragma once

#include <pybind11/pybind11.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "made.h"

namespace isimp::bindings {

namespace py = pybind11;

/// A Python value as an option's type; `name` ("PartitionOptions.proxies") is for the message.
/// \throws InvalidInput  another type than wanted, or out of that type's range
std::int64_t to_integer(py::handle value, const std::string& name, std::int64_t low, std::int64_t high);
std::uint64_t to_unsigned(py::handle value, const std::string& name);
double to_number(py::handle value, const std::string& name);
bool to_bool(py::handle value, const std::string& name);
std::string to_text(py::handle value, const std::string& name);

template <class T>
T to_option(py::handle value, const std::string& name) {
  if constexpr (std::is_same_v<T, bool>)
    return to_bool(value, name);
  else if constexpr (std::is_same_v<T, std::uint64_t>)
    return to_unsigned(value, name);
  else if constexpr (std::is_integral_v<T>)
    return static_cast<T>(to_integer(value, name, std::numeric_limits<T>::min(), std::numeric_limits<T>::max()));
  else if constexpr (std::is_floating_point_v<T>)
    return to_number(value, name);
  else
    return to_text(value, name);
}

/// \throws InvalidInput  the message lists the names
std::size_t to_choice(py::handle value, const std::string& name, const std::vector<std::string>& names);

/// Makes a Python class of a struct of options: keyword construction, fields that can be read and set, repr, equality,
/// copy and pickle. Defaults are the struct's own, so they are written down once.
template <class Options>
class OptionsClass {
 public:
  OptionsClass(py::module_& m, const char* name, const char* doc)
      : name_(name), fields_(std::make_shared<Fields>()), class_(m, name, py::module_local(), doc) {}

  template <class T>
  OptionsClass& field(const char* name, T Options::*member, const char* doc) {
    return add(
        name, [member](const Options& options) -> py::object { return py::cast(options.*member); },
        [member](Options& options, py::handle value, const std::string& full) {
          options.*member = to_option<T>(value, full);
        },
        doc);
  }

  /// A field that may also be None.
  template <class T>
  OptionsClass& field(const char* name, std::optional<T> Options::*member, const char* doc) {
    return add(
        name,
        [member](const Options& options) -> py::object {
          return options.*member ? py::object(py::cast(*(options.*member))) : py::object(py::none());
        },
        [member](Options& options, py::handle value, const std::string& full) {
          options.*member = value.is_none() ? std::nullopt : std::optional<T>(to_option<T>(value, full));
        },
        doc);
  }

  /// An enumeration, by names in Python.
  template <class Enum>
  OptionsClass& choice(const char* name, Enum Options::*member, std::vector<std::pair<std::string, Enum>> choices,
                       const char* doc) {
    std::vector<std::string> names;
    for (const auto& [text, value] : choices) names.push_back(text);
    return add(
        name,
        [member, choices](const Options& options) -> py::object {
          for (const auto& [text, value] : choices)
            if (value == options.*member) return py::str(text);
          return py::none();
        },
        [member, choices, names](Options& options, py::handle value, const std::string& full) {
          options.*member = choices[to_choice(value, full, names)].second;
        },
        doc);
  }

  void finish() {
    const auto fields = fields_;
    const std::string name = name_;
    const auto make = [fields, name](const py::dict& values) {
      Options options;
      for (const auto& [key, value] : values) set(*fields, options, name, key, value);
      return options;
    };
    class_.def(py::init([make](const py::kwargs& values) { return make(values); }))
        .def(
            "as_dict", [fields](const Options& options) { return dict(*fields, options); }, "The fields by name.")
        .def("__repr__",
             [fields, name](const Options& options) {
               std::string text;
               for (const auto& field : *fields)
                 text += (text.empty() ? "" : ", ") + field.name + "=" + std::string(py::repr(field.get(options)));
               return name + "(" + text + ")";
             })
        .def("__eq__",
             [fields](const Options& options, const py::object& other) -> py::object {
               if (!py::isinstance<Options>(other)) return py::reinterpret_borrow<py::object>(Py_NotImplemented);
               return py::bool_(dict(*fields, options).equal(dict(*fields, other.cast<const Options&>())));
             })
        .def(py::pickle([fields](const Options& options) { return dict(*fields, options); }, make));
  }

 private:
  struct Field {
    std::string name;
    std::function<py::object(const Options&)> get;
    std::function<void(Options&, py::handle, const std::string&)> set;
  };
  using Fields = std::vector<Field>;

  template <class Get, class Set>
  OptionsClass& add(const char* name, Get get, Set set, const char* doc) {
    const std::string full = name_ + "." + name;
    class_.def_property(
        name, get, [set, full](Options& options, const py::object& value) { set(options, value, full); }, doc);
    fields_->push_back({name, get, set});
    return *this;
  }

  static py::dict dict(const Fields& fields, const Options& options) {
    py::dict values;
    for (const Field& field : fields) values[py::str(field.name)] = field.get(options);
    return values;
  }

  static void set(const Fields& fields, Options& options, const std::string& owner, py::handle name, py::handle value) {
    std::string known;
    for (const Field& field : fields) {
      if (name.equal(py::str(field.name))) return field.set(options, value, owner + "." + field.name);
      known += (known.empty() ? "" : ", ") + field.name;
    }
    throw py::type_error(owner + " has no field " + std::string(py::repr(name)) + "; its fields are " + known);
  }

  std::string name_;
  std::shared_ptr<Fields> fields_;
  py::class_<Options> class_;
};

}  // namespace isimp::bindings
