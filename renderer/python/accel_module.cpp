// The extension module kindling._accel: a scene that traces NumPy arrays of rays.
//
// Its functions return tuples of arrays; kindling/accel/__init__.py gives them names.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/python/traced_scene.h"

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>

#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>

namespace {

using namespace kindling;
using namespace kindling::python;

template <class T>
using Column = nb::ndarray<nb::numpy, T, nb::ndim<1>>;

// A new NumPy array that owns its memory, not initialized, and the memory.
template <class T>
struct NewColumn {
  T* data;
  Column<T> array;

  explicit NewColumn(size_t size) : data(new T[size]), array(data, {size}, owner()) {}

 private:
  nb::capsule owner() const {
    return nb::capsule(data, [](void* memory) noexcept { delete[] static_cast<T*>(memory); });
  }
};

void check_threads(int threads) {
  if (threads < 0)
    throw nb::value_error(
        ("threads: " + std::to_string(threads) + ", expected 0 for all, or a number of threads").c_str());
}

accel::Kind kind_of(const std::string& name) {
  const std::optional<accel::Kind> kind = accel::kind_from_name(name);
  if (!kind)
    throw nb::value_error(("accelerator: '" + name + "', expected 'kdtree', 'embree' or 'brute-force'").c_str());
  return *kind;
}

accel::Quality quality_of(const std::string& name) {
  const std::optional<accel::Quality> quality = accel::quality_from_name(name);
  if (!quality) throw nb::value_error(("quality: '" + name + "', expected 'fast', 'balanced' or 'best'").c_str());
  return *quality;
}

// Converts a matrix for column vectors, as NumPy programs write it.
Imath::M44f matrix_of(const Array& array, size_t instance) {
  const std::string name = "instances[" + std::to_string(instance) + "]: matrix";
  const Floats rows(array, name.c_str(), 4);
  if (array.ndim() != 2 || rows.rows() != 4)
    throw nb::value_error((name + ": shape " + shape_text(array) + ", expected (4, 4)").c_str());
  return rows.matrix();
}

std::unique_ptr<TracedScene> make_scene(const nb::sequence& meshes, const nb::object& instances,
                                        const std::string& accelerator, const std::string& quality, bool robust,
                                        int threads) {
  const accel::Kind kind = kind_of(accelerator);
  const accel::Quality effort = quality_of(quality);
  check_threads(threads);
  auto scene = std::make_unique<TracedScene>();
  for (const nb::handle mesh : meshes) scene->add_mesh(nb::cast<Array>(mesh[0]), nb::cast<Array>(mesh[1]));
  if (instances.is_none()) {
    for (size_t m = 0; m < scene->mesh_count(); ++m) scene->add_instance({static_cast<uint32_t>(m), Imath::M44f()});
  } else {
    size_t number = 0;
    for (const nb::handle instance : instances) {
      const auto mesh = nb::cast<int64_t>(instance[0]);
      const uint32_t index = mesh < 0 || mesh > 0xffffffff ? accel::kNoId : static_cast<uint32_t>(mesh);
      scene->add_instance({index, matrix_of(nb::cast<Array>(instance[1]), number++)});
    }
  }
  {
    const nb::gil_scoped_release release;
    scene->build(kind, effort, robust, threads);
  }
  return scene;
}

nb::tuple intersect(const TracedScene& scene, const Array& origins, const Array& directions, const Array& t_min,
                    const Array& t_max, int threads) {
  check_threads(threads);
  const RayArrays rays = ray_arrays(origins, directions, t_min, t_max);
  NewColumn<float> t(rays.count), u(rays.count), v(rays.count);
  NewColumn<int32_t> triangle(rays.count), mesh(rays.count), instance(rays.count);
  {
    const nb::gil_scoped_release release;
    scene.intersect(rays, threads, [&](size_t first, std::span<const accel::Hit> hits) {
      for (size_t i = 0; i < hits.size(); ++i) {
        const accel::Hit& hit = hits[i];
        t.data[first + i] = hit.is_hit() ? hit.t : std::numeric_limits<float>::infinity();
        u.data[first + i] = hit.is_hit() ? hit.u : 0.0f;
        v.data[first + i] = hit.is_hit() ? hit.v : 0.0f;
        triangle.data[first + i] = static_cast<int32_t>(hit.triangle); // kNoId becomes -1
        mesh.data[first + i] = static_cast<int32_t>(hit.mesh);
        instance.data[first + i] = static_cast<int32_t>(hit.instance);
      }
    });
  }
  return nb::make_tuple(t.array, u.array, v.array, triangle.array, mesh.array, instance.array);
}

Column<bool> occluded(const TracedScene& scene, const Array& origins, const Array& directions, const Array& t_min,
                      const Array& t_max, int threads) {
  check_threads(threads);
  const RayArrays rays = ray_arrays(origins, directions, t_min, t_max);
  NewColumn<bool> blocked(rays.count);
  static_assert(sizeof(bool) == sizeof(uint8_t)); // both hold 0 or 1
  {
    const nb::gil_scoped_release release;
    scene.occluded(rays, threads, reinterpret_cast<uint8_t*>(blocked.data));
  }
  return blocked.array;
}

nb::tuple all_hits(const TracedScene& scene, const Array& origins, const Array& directions, const Array& t_min,
                   const Array& t_max, int64_t limit, int threads) {
  check_threads(threads);
  const RayArrays rays = ray_arrays(origins, directions, t_min, t_max);
  const size_t max_hits = limit < 0 ? accel::kNoLimit : static_cast<size_t>(limit);
  accel::CrossingLists lists;
  {
    const nb::gil_scoped_release release;
    lists = scene.all_hits(rays, max_hits, threads);
  }
  const size_t count = lists.crossings.size();
  NewColumn<int64_t> first(rays.count + 1), ray(count);
  NewColumn<float> t(count), u(count), v(count);
  NewColumn<int32_t> triangle(count), mesh(count), instance(count);
  NewColumn<bool> front(count);
  const auto write = [&](size_t r) {
    first.data[r] = static_cast<int64_t>(lists.first[r]);
    for (size_t i = lists.first[r]; i < lists.first[r + 1]; ++i) {
      const accel::Hit& hit = lists.crossings[i].hit;
      ray.data[i] = static_cast<int64_t>(r);
      t.data[i] = hit.t;
      u.data[i] = hit.u;
      v.data[i] = hit.v;
      triangle.data[i] = static_cast<int32_t>(hit.triangle);
      mesh.data[i] = static_cast<int32_t>(hit.mesh);
      instance.data[i] = static_cast<int32_t>(hit.instance);
      front.data[i] = lists.crossings[i].front;
    }
  };
  first.data[rays.count] = static_cast<int64_t>(count);
  {
    const nb::gil_scoped_release release;
    for_blocks(rays.count, threads, [&](size_t begin, size_t size) {
      for (size_t r = begin; r < begin + size; ++r) write(r);
    });
  }
  return nb::make_tuple(first.array, ray.array, t.array, u.array, v.array, triangle.array, mesh.array, instance.array,
                        front.array);
}

nb::dict statistics(const TracedScene& scene) {
  const accel::Statistics s = scene.accelerator().statistics();
  nb::dict out;
  out["build_s"] = s.build_s;
  out["memory_bytes"] = s.memory_bytes;
  out["triangle_count"] = s.triangle_count;
  out["instance_count"] = s.instance_count;
  out["kernels"] = std::string(accel::simd_target_name(s.simd));
  return out;
}

nb::tuple bounds(const TracedScene& scene) {
  const Imath::Box3f box = scene.accelerator().bounds();
  return nb::make_tuple(nb::make_tuple(box.min.x, box.min.y, box.min.z),
                        nb::make_tuple(box.max.x, box.max.y, box.max.z));
}

} // namespace

NB_MODULE(_accel, module) {
  module.doc() = "Kindling's accelerators; use kindling.accel.";
  module.def("description",
             [](const std::string& name) { return std::string(accel::kind_description(kind_of(name))); });
  nb::class_<TracedScene>(module, "Scene")
      .def_static("make", &make_scene, nb::arg("meshes"), nb::arg("instances").none(), nb::arg("accelerator"),
                  nb::arg("quality"), nb::arg("robust"), nb::arg("threads"))
      .def("intersect", &intersect)
      .def("occluded", &occluded)
      .def("all_hits", &all_hits)
      .def("statistics", &statistics)
      .def("bounds", &bounds);
}
