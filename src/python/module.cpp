// `import fumarole`: scenes and densities to arrays. Everything takes and gives numpy arrays of
// floats with rows from the top; a density is indexed [z, y, x]. Errors of the library are
// fumarole.Error. The interpreter runs on while a picture is drawn.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "context/headless_context.h"
#include "study/flip.h"
#include "study/metrics.h"
#include "study/reference.h"
#include <fumarole/asset/auto_scene.h>
#include <fumarole/asset/scene_file.h>
#include <fumarole/asset/vdb_file.h>
#include <fumarole/errors.h>
#include <fumarole/log.h>
#include <fumarole/scene_renderer.h>
#include <fumarole/settings.h>
#include <fumarole/write/image_writer.h>

namespace fumarole::python {

namespace {

namespace py = pybind11;

/// C order, floats: numpy converts whatever else it is given.
using Array = py::array_t<float, py::array::c_style | py::array::forcecast>;
using Vec3 = std::array<double, 3>;

glm::dvec3 to_dvec3(const Vec3& v)
{
    return {v[0], v[1], v[2]};
}

/// What the library has said on this thread, kept while the interpreter's lock is released.
thread_local std::vector<std::pair<LogLevel, std::string>> said;

/// Tells it: a warning by warnings.warn, a choice that was made to the logger "fumarole".
/// @throws py::error_already_set where a filter makes errors of warnings
void tell_what_was_said()
{
    for (const auto& [level, line] : std::exchange(said, {}))
        if (level == LogLevel::info)
            py::module_::import("logging").attr("getLogger")("fumarole").attr("info")("%s", line);
        else if (PyErr_WarnEx(PyExc_UserWarning, line.c_str(), 1) != 0)
            throw py::error_already_set();
}

/// A context is current on one thread alone, so that each has its own.
SceneRenderer& renderer()
{
    thread_local std::unique_ptr<gl::HeadlessContext> context;
    thread_local std::unique_ptr<SceneRenderer> renderer;
    if (!renderer) {
        context = gl::HeadlessContext::make();
        renderer = std::make_unique<SceneRenderer>(
            context->get_proc(),
            [](LogLevel level, std::string_view line) { said.emplace_back(level, line); });
    }
    return *renderer;
}

/// @param channels 1 makes an array of two dimensions
Array to_array(const std::vector<float>& pixels, int width, int height, int channels)
{
    std::vector<py::ssize_t> shape{height, width};
    if (channels > 1)
        shape.push_back(channels);
    Array array(shape);
    std::copy(pixels.begin(), pixels.end(), array.mutable_data());
    return array;
}

std::span<const float> span_of(const Array& array)
{
    return {array.data(), static_cast<std::size_t>(array.size())};
}

struct Size {
    int width, height;
};

/// Of a picture of three channels. @throws Error
Size size_of(const Array& picture, const char* name)
{
    if (picture.ndim() != 3 || picture.shape(2) != 3)
        throw Error(fmt::format("{}: give an array of the shape (height, width, 3)", name));
    return {static_cast<int>(picture.shape(1)), static_cast<int>(picture.shape(0))};
}

/// As many numbers may be a picture of another shape. @throws Error
void check_same_shape(const Array& test, const Array& reference)
{
    if (!std::equal(test.shape(), test.shape() + test.ndim(), reference.shape(),
                    reference.shape() + reference.ndim()))
        throw Error("test, reference: give arrays of one shape");
}

/// What of a still both kinds have. @param still is a Still or a ReferenceStill
template <class AnyStill> py::dict arrays_of(const AnyStill& still)
{
    const auto rgb = [&](const std::vector<float>& pixels) {
        return to_array(pixels, still.width, still.height, 3);
    };
    py::dict arrays;
    arrays["composite"] = rgb(still.composite);
    arrays["scattering"] = rgb(still.scattering);
    arrays["transmittance"] = rgb(still.transmittance);
    arrays["surface"] = rgb(still.surface);
    arrays["surface_lit"] = rgb(still.surface_lit);
    arrays["depth"] = to_array(still.depth, still.width, still.height, 1);
    return arrays;
}

/// steps=32, world_light="off", noise_grid=True
Settings settings_of(const std::string& preset, const py::kwargs& changed)
{
    Settings settings = find_preset(preset);
    for (const auto& [key, value] : changed) {
        const std::string given = py::str(key);
        std::string name = given, text = py::str(value);
        std::replace(name.begin(), name.end(), '_', '-');
        if (const std::string_view now = present_name(name); now != name) {
            name = now;
            std::string keyword = name;
            std::replace(keyword.begin(), keyword.end(), '-', '_');
            const std::string line =
                fmt::format("{} is now called {}; the old name is accepted by this release only",
                            given, keyword);
            if (PyErr_WarnEx(PyExc_FutureWarning, line.c_str(), 1) != 0)
                throw py::error_already_set();
        }
        if (py::isinstance<py::bool_>(value))
            text = value.cast<bool>() ? "on" : "off";
        if (name == "mode")
            settings.mode = find_mode(text);
        else
            find_setting(name).set(settings, text);
    }
    return settings;
}

/// A scene, whose parts that a test changes are properties.
struct PyScene {
    Scene scene;
    std::vector<std::string> notes;
};

PyScene load(const std::string& file, std::optional<std::array<unsigned, 2>> size,
             const std::string& grid)
{
    const py::gil_scoped_release released;
    asset::LoadedScene loaded;
    if (std::filesystem::path(file).extension() == ".json") {
        loaded = asset::load_scene(file);
    } else {
        asset::AutoSceneOptions options;
        options.grid = grid;
        loaded = asset::make_auto_scene(file, options);
    }
    if (size)
        loaded.scene.resolution = {(*size)[0], (*size)[1]};
    return {std::move(loaded.scene), std::move(loaded.notes)};
}

/// A density in memory before a camera that has all of it in view, under one sun and a sky.
PyScene from_density(const Array& density, double voxel_size, const Vec3& sigma_s,
                     const Vec3& sigma_a, float g, std::array<unsigned, 2> size)
{
    if (density.ndim() != 3)
        throw Error("density: give an array of three dimensions, [z, y, x]");
    if (!(voxel_size > 0))
        throw Error(fmt::format("voxel_size: {:g} is not above 0 (metres)", voxel_size));
    const glm::ivec3 voxels(static_cast<int>(density.shape(2)), static_cast<int>(density.shape(1)),
                            static_cast<int>(density.shape(0)));
    glm::dmat4 world_from_index(voxel_size);
    world_from_index[3] = {-0.5 * voxel_size * (voxels.x - 1), -0.5 * voxel_size * (voxels.y - 1),
                           0.5 * voxel_size, 1};
    GridMedium medium;
    medium.density = std::make_shared<const VoxelGrid>(
        make_voxel_grid(span_of(density), voxels, world_from_index));
    medium.sigma_s_per_density = glm::vec3(to_dvec3(sigma_s));
    medium.sigma_a_per_density = glm::vec3(to_dvec3(sigma_a));
    medium.g = g;
    PyScene made;
    Scene& scene = made.scene;
    scene.media = {medium};
    scene.lights = {SunLight{.direction_to_light = {-1, -1, 1}, .irradiance = {5, 5, 4}}};
    scene.world.radiance = {0.2f, 0.25f, 0.3f};
    scene.resolution = {size[0], size[1]};
    const glm::dvec3 extent = glm::dvec3(voxels) * voxel_size;
    Camera& camera = scene.camera;
    camera.look_at = {0, 0, extent.z / 2};
    const double half = glm::radians(camera.vfov_deg) / 2;
    const double narrow = half * std::min(1.0, double(size[0]) / size[1]);
    camera.position =
        camera.look_at - glm::dvec3(0, 0.5 * glm::length(extent) / std::sin(narrow), 0);
    camera.near = 1e-3 * glm::length(extent);
    camera.far = 100 * glm::length(extent);
    return made;
}

py::dict render(const PyScene& scene, const std::string& preset, int aa, std::uint32_t seed,
                const py::kwargs& changed)
{
    const Settings settings = settings_of(preset, changed);
    StillOptions options;
    options.aa = aa;
    options.seed = seed;
    Still still;
    {
        const py::gil_scoped_release released;
        said.clear();
        still = renderer().render(scene.scene, settings, options);
    }
    tell_what_was_said();
    return arrays_of(still);
}

py::dict reference(const PyScene& scene, double tolerance, std::optional<int> bounces,
                   std::optional<int> surface_bounces, int aa)
{
    study::ReferenceOptions options;
    options.tolerance = tolerance;
    options.bounces = bounces.value_or(study::kAllBounces);
    options.surface_bounces = surface_bounces.value_or(study::kAllBounces);
    options.aa = aa;
    study::ReferenceStill still;
    {
        const py::gil_scoped_release released;
        still = study::render_reference(scene.scene, options);
    }
    py::dict arrays = arrays_of(still);
    arrays["error"] = to_array(still.error, still.width, still.height, 1);
    return arrays;
}

py::dict compare(const Array& test, const Array& reference)
{
    check_same_shape(test, reference);
    const study::Metrics metrics = study::compare(span_of(test), span_of(reference));
    py::dict out;
    out["relmse"] = metrics.relmse;
    out["smape"] = metrics.smape;
    out["bias"] = metrics.bias;
    out["p999"] = metrics.p999;
    return out;
}

py::tuple flip(const Array& test, const Array& reference, float exposure)
{
    const Size size = size_of(test, "test");
    check_same_shape(test, reference);
    const study::Flip flip = study::flip_of_radiance(span_of(test), span_of(reference), size.width,
                                                     size.height, {.exposure_ev = exposure});
    return py::make_tuple(flip.mean, to_array(flip.map, size.width, size.height, 1));
}

py::tuple load_grid(const std::string& file, const std::string& name)
{
    asset::LoadedGrid loaded;
    {
        const py::gil_scoped_release released;
        loaded = asset::load_grid(file, name);
    }
    const VoxelGrid& grid = loaded.grid;
    const glm::ivec3 size = grid.empty() ? glm::ivec3(0) : grid.index_max - grid.index_min + 1;
    constexpr double kMost = 4e9;  // values
    if (glm::dvec3(size).x * size.y * size.z * grid.channels > kMost)
        throw Error(fmt::format("{}: grid '{}' of {} x {} x {} voxels is too large for an array",
                                file, grid.name, size.x, size.y, size.z));
    std::vector<py::ssize_t> shape{size.z, size.y, size.x};
    if (grid.channels > 1)
        shape.push_back(grid.channels);
    Array array(shape);
    float* out = array.mutable_data();
    {
        const py::gil_scoped_release released;
        const VoxelLookup lookup(grid);
        for (int z = 0; z < size.z; ++z)
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x) {
                    const glm::vec3 value = lookup.value(grid.index_min + glm::ivec3(x, y, z));
                    for (int c = 0; c < grid.channels; ++c)
                        *out++ = value[c];
                }
    }
    py::array_t<double> matrix({4, 4});
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column)
            matrix.mutable_at(row, column) = grid.world_from_index[column][row];
    return py::make_tuple(array, matrix,
                          py::make_tuple(grid.index_min.x, grid.index_min.y, grid.index_min.z));
}

Image image_of(const Array& picture)
{
    const Size size = size_of(picture, "picture");
    Image image;
    image.width = size.width;
    image.height = size.height;
    image.channels = {"R", "G", "B"};
    image.pixels.assign(picture.data(), picture.data() + picture.size());
    return image;
}

void save(const Array& picture, const std::string& file, std::optional<float> exposure)
{
    const Image image = image_of(picture);
    if (std::filesystem::path(file).extension() == ".png")
        write::write_png(image, {.exposure_ev = exposure ? *exposure : write::auto_exposure(image)},
                         file);
    else
        write::write_exr(image, file);
}

Vec3 to_array3(glm::dvec3 v)
{
    return {v.x, v.y, v.z};
}

template <glm::dvec3 Camera::*member>
void add_vector(py::class_<PyScene>& scene, const char* name, const char* help)
{
    scene.def_property(
        name, [](const PyScene& s) { return to_array3(s.scene.camera.*member); },
        [](PyScene& s, const Vec3& value) { s.scene.camera.*member = to_dvec3(value); }, help);
}

}  // namespace

PYBIND11_MODULE(fumarole, m)
{
    m.doc() = "Lit smoke, fire, cloud and fog: densities, .vdb files and scenes to arrays.";
    m.attr("__version__") = FUMAROLE_VERSION;
    py::register_exception<Error>(m, "Error", PyExc_RuntimeError);

    py::class_<PyScene> scene(m, "Scene", "Media, lights, surfaces and a camera.");
    scene
        .def_property(
            "size",
            [](const PyScene& s) {
                return std::array{s.scene.resolution.x, s.scene.resolution.y};
            },
            [](PyScene& s, std::array<unsigned, 2> size) {
                s.scene.resolution = {size[0], size[1]};
            },
            "(width, height) of its pictures, in pixels")
        .def_property(
            "vfov", [](const PyScene& s) { return s.scene.camera.vfov_deg; },
            [](PyScene& s, double degrees) { s.scene.camera.vfov_deg = degrees; },
            "the camera's vertical field of view, in degrees")
        .def_property(
            "world", [](const PyScene& s) { return to_array3(glm::dvec3(s.scene.world.radiance)); },
            [](PyScene& s, const Vec3& radiance) {
                s.scene.world.radiance = glm::vec3(to_dvec3(radiance));
            },
            "the sky's radiance, where there is no map")
        .def_readonly("notes", &PyScene::notes, "what was said while it was read")
        .def(
            "json",
            [](const PyScene& s) {
                return asset::scene_to_json(s.scene, std::filesystem::current_path());
            },
            "the scene as a scene file has it");
    add_vector<&Camera::position>(scene, "position", "where the camera stands, in metres");
    add_vector<&Camera::look_at>(scene, "look_at", "the middle of its picture, in metres");
    add_vector<&Camera::up>(scene, "up", "what is up in its picture");

    m.def("load", &load, py::arg("file"), py::arg("size") = py::none(), py::arg("grid") = "",
          "A scene from a scene file (.json), or one that suits a .vdb or .nvdb.");
    m.def("from_density", &from_density, py::arg("density"), py::kw_only(),
          py::arg("voxel_size") = 0.1, py::arg("sigma_s") = Vec3{1, 1, 1},
          py::arg("sigma_a") = Vec3{0, 0, 0}, py::arg("g") = 0.0f,
          py::arg("size") = std::array<unsigned, 2>{320, 180},
          "A scene of one density [z, y, x], z up, seen along y, under a sun and a sky. "
          "sigma_s, sigma_a: coefficients per metre and unit of density.");
    m.def("render", &render, py::arg("scene"), py::kw_only(), py::arg("preset") = "default",
          py::arg("aa") = 1, py::arg("seed") = 0u,
          "The picture and its layers by OpenGL, linear: composite, scattering, transmittance, "
          "surface, surface_lit of the shape (height, width, 3), depth of (height, width). "
          "Other keywords are settings: mode='froxel', steps=64, bounces=0.");
    m.def("reference", &reference, py::arg("scene"), py::kw_only(), py::arg("tolerance") = 0.02,
          py::arg("bounces") = py::none(), py::arg("surface_bounces") = 0, py::arg("aa") = 1,
          "The same on the processor, to a relative tolerance of each pixel; with its own "
          "estimated error. bounces=None counts them all.");
    m.def("compare", &compare, py::arg("test"), py::arg("reference"),
          "relmse, smape, bias and p999 of a picture against a reference, linear.");
    m.def("flip", &flip, py::arg("test"), py::arg("reference"), py::arg("exposure") = 0.0f,
          "FLIP of linear pictures as a screen shows them at an exposure: mean, and a map.");
    m.def("load_grid", &load_grid, py::arg("file"), py::arg("name") = "",
          "One grid of a .vdb or .nvdb: values [z, y, x] (or [z, y, x, 3]) within the bounds of "
          "what is not 0, world_from_index (4 x 4), and the index (x, y, z) of the first value.");
    m.def("save", &save, py::arg("picture"), py::arg("file"), py::arg("exposure") = py::none(),
          "Writes a linear picture as .exr, or as .png for a screen.");
}

}  // namespace fumarole::python
