// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "bindings/python/bind.h"
#include "panoptic/map.h"
#include "panoptic/query.h"

namespace panoptic::python {

// An object, and the name of its class.
struct NamedObject {
  FoundObject object;
  std::string class_name;
};
NamedObject named(const FoundObject& object, const LabelSet& labels);

// The number of an object; None for kUnknown.
inline py::object id_or_none(PanopticId id) {
  return id == PanopticId::kUnknown ? py::object(py::none()) : py::object(py::int_(number(id)));
}

// The number of an object that is given by it, or as a MapObject. Throws Error.
std::int64_t object_number(const py::handle& object);

// Everything that the registry knows of an object, by name. Throws Error if there is none with this id.
py::dict explain_object(const PanopticMap& map, std::int64_t id);

void bind_objects(py::module_& m);

}  // namespace panoptic::python
