#include <fumarole/asset/scene_file.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <map>
#include <sstream>
#include <system_error>
#include <utility>

#include "asset/json_reader.h"
#include "asset/json_writer.h"
#include "asset/motion_blur.h"
#include "asset/scene_ranges.h"
#include "asset/scene_transparents.h"
#include "light_fields.h"
#include "pictures/ahead.h"
#include "write/whole_file.h"
#include <fumarole/asset/animation.h>
#include <fumarole/asset/environment_map.h>
#include <fumarole/asset/image_file.h>
#include <fumarole/asset/mesh_file.h>
#include <fumarole/asset/vdb_file.h>
#include <fumarole/errors.h>

namespace fumarole::asset {

namespace {

namespace fs = std::filesystem;

// ------------------------------------------------------------------------------- what is allowed

// Sine of the angle below which `up` gives a camera no orientation.
constexpr double kMinSine = 1e-6;
constexpr double kMaxCosine =
    1e-3;  ///< largest cosine of edges that count as at right angles, as files have few digits

// A scene is text that someone wrote; whatever is longer was named by mistake.
constexpr std::uintmax_t kMaxFileBytes = 64U << 20U;

// ------------------------------------------------------------------------------- JSON to a scene

// Unit length, but the very bits of a vector that has it already: a written scene reads back equal.
glm::dvec3 unit_direction(glm::dvec3 v, const JsonPlace& place)
{
    const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    if (largest == 0)
        place.fail("expected a direction, got [0, 0, 0]");
    if (std::abs(glm::dot(v, v) - 1) <= 1e-15)
        return v;
    v /= largest;  // so that the squares of tiny numbers do not vanish
    return glm::normalize(v);
}

void check_box(const JsonObject& object, const glm::dvec3& min, const glm::dvec3& max,
               const std::string& prefix = "")
{
    for (int axis = 0; axis < 3; ++axis) {
        if (!(min[axis] < max[axis]))
            object.place()
                .key(prefix + "max")
                .fail(fmt::format(
                    "expected more than {}min on every axis, got {} = {} where {}min has {}",
                    prefix, "xyz"[axis], max[axis], prefix, min[axis]));
    }
}

/// What a key of a path leaves out it has from the key before it, but for where it is and looks.
Camera read_camera(JsonObject& object, const Camera* before)
{
    Camera camera = before != nullptr ? *before : Camera{};
    object.need("position", kCoordinate, camera.position);
    object.need("look_at", kCoordinate, camera.look_at);
    object.read("up", kDirection, camera.up);
    camera.projection = object.choice("projection", {"perspective", "orthographic"},
                                      static_cast<std::size_t>(camera.projection)) == 0
                            ? Camera::Projection::perspective
                            : Camera::Projection::orthographic;
    object.read("ortho_height", kLengthOrNone, camera.ortho_height);
    // One or the other says how much is seen.
    const bool by_height =
        camera.projection == Camera::Projection::orthographic && camera.ortho_height > 0;
    if (before == nullptr && !by_height)
        object.need("vfov_deg", kAngle, camera.vfov_deg);
    else
        object.read("vfov_deg", kAngle, camera.vfov_deg);
    object.read("near", kLength, camera.near);
    object.read("far", kLength, camera.far);
    object.finish();

    if (!(camera.near < camera.far))
        object.place().key("far").fail(fmt::format(
            "expected more than near, got {} where near is {}", camera.far, camera.near));
    const glm::dvec3 view = camera.look_at - camera.position;
    if (view == glm::dvec3(0))
        object.place().key("look_at").fail("expected another point than position");
    const glm::dvec3 forward = unit_direction(view, object.place().key("look_at"));
    const glm::dvec3 up = unit_direction(camera.up, object.place().key("up"));
    if (glm::length(glm::cross(forward, up)) < kMinSine)
        object.place().key("up").fail(
            "expected a direction across the view, got one parallel to look_at - position");
    return camera;
}

std::vector<CameraKey> read_camera_path(const Json& list, const JsonPlace& place)
{
    std::vector<CameraKey> path;
    for (std::size_t i = 0; i < list.size(); ++i) {
        JsonObject object(list[i], place.index(i));
        CameraKey key;
        object.need("time", kTime, key.time);
        key.camera = read_camera(object, path.empty() ? nullptr : &path.back().camera);
        if (!path.empty() && !(key.time > path.back().time))
            object.place().key("time").fail(
                fmt::format("expected more than the key's before, got {} after {}", key.time,
                            path.back().time));
        if (!path.empty() && key.camera.projection != path.back().camera.projection)
            object.place().key("projection").fail("expected the same in all keys");
        path.push_back(key);
    }
    if (path.empty())
        place.fail("expected a camera, or a list of at least one with times");
    return path;
}

World read_world(const Json& value, const JsonPlace& place, const fs::path& folder)
{
    World world;
    if (!value.is_object()) {
        world.radiance = json_value<glm::vec3>(value, place, kRadiance);
        return world;
    }
    JsonObject object(value, place);
    object.need_file("environment", world.environment_file);
    object.read("scale", {0, kMaxValue}, world.environment_scale);
    object.finish();
    world.environment_file = resolved(folder, world.environment_file).string();
    return world;
}

/// Reads a light's fields; a direction is made one only once all keys are known to be right.
class LightReader {
public:
    explicit LightReader(JsonObject& object) : object_{object} {}

    void to_light(const LightField& field, glm::dvec3& d) { direction(field, d); }
    void axis(const LightField& field, glm::dvec3& d) { direction(field, d); }
    void position(const LightField& field, glm::dvec3& p) { get(field, kCoordinate, p); }
    void number(const LightField& field, double& value)
    {
        get(field, {field.min, field.max, field.open, field.open, field.unit}, value);
    }
    void flag(const LightField& field, bool& value) { object_.read(field.key, value); }
    void edges(const LightField& field, std::array<glm::dvec3, 2>& value)
    {
        get(field, kCoordinate, value);
        const double cosine = glm::dot(value[0], value[1]) /
                              std::max(glm::length(value[0]) * glm::length(value[1]), 1e-300);
        if (std::abs(cosine) > kMaxCosine)
            object_.place().key(field.key).fail(
                fmt::format("expected two edges at right angles, got {:.2f} degrees",
                            glm::degrees(std::acos(std::clamp(cosine, -1.0, 1.0)))));
    }
    void power(const LightField& field, glm::vec3& value)
    {
        get(field, {0, kMaxValue, false, false, field.unit}, value);
    }

    void finish()
    {
        object_.finish();
        for (const auto& [key, d] : directions_)
            *d = unit_direction(*d, object_.place().key(key));
    }

private:
    template <typename T> void get(const LightField& field, const NumberRange& range, T& value)
    {
        if (field.optional)
            object_.read(field.key, range, value);
        else
            object_.need(field.key, range, value);
    }
    void direction(const LightField& field, glm::dvec3& d)
    {
        get(field, kDirection, d);
        directions_.emplace_back(field.key, &d);
    }

    JsonObject& object_;
    std::vector<std::pair<const char*, glm::dvec3*>> directions_;
};

Light read_light(JsonObject object)
{
    std::vector<std::string_view> names;
    for (const Light& type : light_types())
        names.emplace_back(light_name(type));
    Light light = light_types()[object.need_choice("type", names)];
    LightReader reader(object);
    visit_light(reader, light);
    object.ignore("radius");
    reader.finish();
    return light;
}

/// Of MediumMotion::Unit, as a file names them.
const std::vector<std::string_view>& velocity_units()
{
    static const std::vector<std::string_view> names{"m/s", "voxels/frame"};
    return names;
}

GridMedium read_grid_medium(JsonObject& object, const fs::path& folder)
{
    GridMedium medium;
    object.need_file("file", medium.file);
    object.read("grid", medium.grid);
    object.read("translate", kCoordinate, medium.translate);
    object.read("scale", kScale, medium.scale);
    object.need("sigma_s_per_density", kCoefficient, medium.sigma_s_per_density);
    object.read("sigma_a_per_density", kCoefficient, medium.sigma_a_per_density);
    object.read("g", kAnisotropy, medium.g);
    object.read("emission_grid", medium.emission_grid);
    const bool has_emission = object.read("emission_per_unit", kEmission, medium.emission_per_unit);
    object.read("color_grid", medium.color_grid);
    object.read("temperature_grid", medium.temperature_grid);
    const char* of_temperature = nullptr;
    const auto read_of_temperature = [&](const char* key, const NumberRange& range, auto& value) {
        if (object.read(key, range, value) && of_temperature == nullptr)
            of_temperature = key;
    };
    read_of_temperature("temperature_scale", kKelvin, medium.temperature_scale);
    read_of_temperature("blackbody_intensity", kFactor, medium.blackbody_intensity);
    read_of_temperature("blackbody_tint", kFactor, medium.blackbody_tint);
    object.read("velocity_grid", medium.motion.velocity_grid);
    const bool has_unit = object.find("velocity_unit") != nullptr;
    medium.motion.unit =
        static_cast<MediumMotion::Unit>(object.choice("velocity_unit", velocity_units(), 0));
    const bool has_shutter = object.read("shutter", kShutter, medium.motion.shutter);
    object.finish();
    if ((has_shutter || has_unit) && medium.motion.velocity_grid.empty())
        object.place().fail(fmt::format("'{}' needs 'velocity_grid', by which the medium moves",
                                        has_shutter ? "shutter" : "velocity_unit"));
    if (of_temperature != nullptr && medium.temperature_grid.empty())
        object.place().fail(
            fmt::format("'{}' needs 'temperature_grid', the grid that glows", of_temperature));
    if (has_emission != !medium.emission_grid.empty())
        object.place().fail(
            has_emission ? "'emission_per_unit' needs 'emission_grid', the grid it multiplies"
                         : "'emission_grid' needs 'emission_per_unit' (expected three "
                           "numbers, W/m^2/sr per metre)");
    medium.file = resolved(folder, medium.file).string();
    return medium;
}

NoiseProfile read_noise(JsonObject object)
{
    NoiseProfile noise;
    object.read("feature_size", kLength, noise.feature_size);
    object.read("octaves", {1, 16}, noise.octaves);
    object.read("gain", {0, 1, true, false}, noise.gain);
    object.read("lacunarity", kLacunarity, noise.lacunarity);
    object.read("threshold", {0, 1, false, true}, noise.threshold);
    object.read("seed", {0, std::numeric_limits<std::uint32_t>::max()}, noise.seed);
    object.read("drift_m_per_s", kSpeed, noise.drift);
    object.finish();
    return noise;
}

BoxMedium read_box_medium(JsonObject& object)
{
    BoxMedium medium;
    object.need("min", kCoordinate, medium.min);
    object.need("max", kCoordinate, medium.max);
    const std::size_t profile = object.choice("profile", {"homogeneous", "exp_height", "noise"}, 0);
    if (profile == 1) {
        ExpHeightProfile falloff;
        object.need("scale_height", kLength, falloff.scale_height);
        object.read("z0", kCoordinate, falloff.z0);
        medium.profile = falloff;
    } else if (profile == 2) {
        const JsonPlace place = object.place().key("noise");
        const Json* noise = object.find("noise");
        medium.profile = noise == nullptr ? NoiseProfile{} : read_noise(JsonObject(*noise, place));
    }
    object.need("sigma_s", kCoefficient, medium.sigma_s);
    object.read("sigma_a", kCoefficient, medium.sigma_a);
    object.read("g", kAnisotropy, medium.g);
    object.read("emission", kEmission, medium.emission);
    object.finish();
    check_box(object, medium.min, medium.max);
    return medium;
}

Medium read_medium(JsonObject object, const fs::path& folder)
{
    if (object.need_choice("type", {"vdb", "box"}) == 0)
        return read_grid_medium(object, folder);
    return read_box_medium(object);
}

/// glTF 2.0's factors where a surface states one of the two and not the other.
constexpr Gloss kGltfGloss{.roughness = 1, .metallic = 1};

/// What every kind of surface has.
/// @returns what its author left out
template <typename SurfaceKind> FromMesh read_material(JsonObject& object, SurfaceKind& surface)
{
    FromMesh missing;
    missing.albedo = !object.read("albedo", kAlbedo, surface.albedo);
    Gloss gloss = kGltfGloss;
    missing.roughness = !object.read("roughness", kShare, gloss.roughness);
    missing.metallic = !object.read("metallic", kShare, gloss.metallic);
    if (!missing.roughness || !missing.metallic)
        surface.gloss = gloss;
    missing.emission = !object.read("emission", kRadiance, surface.emission);
    return missing;
}

Surface read_surface(JsonObject object, const fs::path& folder)
{
    switch (object.need_choice("type", {"sphere", "box", "mesh"})) {
    case 0: {
        SphereSurface sphere;
        object.need("center", kCoordinate, sphere.center);
        object.need("radius", kLength, sphere.radius);
        read_material(object, sphere);
        object.finish();
        return sphere;
    }
    case 1: {
        BoxSurface box;
        object.need("min", kCoordinate, box.min);
        object.need("max", kCoordinate, box.max);
        read_material(object, box);
        object.finish();
        check_box(object, box.min, box.max);
        return box;
    }
    default: {
        MeshSurface mesh;
        object.need_file("file", mesh.file);
        object.read("translate", kCoordinate, mesh.translate);
        object.read("scale", kScale, mesh.scale);
        const FromMesh missing = read_material(object, mesh);
        if (missing.albedo)  // which else says that the material is the scene's
            mesh.from_mesh = missing;
        object.finish();
        mesh.file = resolved(folder, mesh.file).string();
        return mesh;
    }
    }
}

constexpr std::array<std::string_view, 3> kParallaxNames{"none", "sphere", "box"};

LightProbe read_probe(JsonObject& object)
{
    LightProbe probe;
    object.need("position", kCoordinate, probe.position);
    object.read("radius", kLength, probe.radius);
    object.read("falloff", kShare, probe.falloff);
    probe.parallax = static_cast<LightProbe::Parallax>(
        object.choice("parallax", {kParallaxNames.begin(), kParallaxNames.end()}, 0));
    if (probe.parallax == LightProbe::Parallax::box) {
        object.need("parallax_min", kCoordinate, probe.parallax_min);
        object.need("parallax_max", kCoordinate, probe.parallax_max);
    }
    object.read("size", {16, 512, false, false, "pixels"}, probe.size);
    object.finish();
    if (probe.parallax == LightProbe::Parallax::box)
        check_box(object, probe.parallax_min, probe.parallax_max, "parallax_");
    return probe;
}

Scene scene_from_json(std::string_view text, const std::string& file, const fs::path& folder)
{
    const Json tree = parse_json(text, file);
    JsonObject object(tree, {file, ""});
    Scene scene;
    object.read("resolution", {1, 16384, false, false, "pixels"}, scene.resolution);
    const Json* camera = object.find("camera");
    if (const Json* world = object.find("world_radiance"))
        scene.world = read_world(*world, object.place().key("world_radiance"), folder);
    object.read_list("lights",
                     [&](JsonObject item) { scene.lights.push_back(read_light(std::move(item))); });
    object.read_list("media", [&](JsonObject item) {
        scene.media.push_back(read_medium(std::move(item), folder));
    });
    object.read_list("surfaces", [&](JsonObject item) {
        scene.surfaces.push_back(read_surface(std::move(item), folder));
    });
    object.read_list("transparents", [&](JsonObject item) {
        scene.transparents.push_back(read_transparent(std::move(item), folder));
    });
    object.read_list("probes", [&](JsonObject item) { scene.probes.push_back(read_probe(item)); });
    object.read("time", kTime, scene.time);
    object.read("frames_per_second", kRate, scene.frames_per_second);
    object.finish();
    if (camera == nullptr)
        object.place().fail("missing key 'camera' (expected an object with position, look_at and "
                            "vfov_deg)");
    const JsonPlace place = object.place().key("camera");
    if (camera->is_array()) {
        scene.camera_path = read_camera_path(*camera, place);
        scene.camera = camera_at(scene.camera_path, scene.time);
    } else {
        JsonObject one(*camera, place);
        scene.camera = read_camera(one, nullptr);
    }
    return scene;
}

std::string read_text(const fs::path& file)
{
    std::error_code ignored;
    if (fs::is_directory(file, ignored))
        throw Error(fmt::format("{}: is a folder, expected a scene file", file.string()));
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        throw Error(fmt::format("{}: cannot be opened: {}", file.string(), std::strerror(errno)));
    std::string text;
    std::vector<char> buffer(1U << 16U);
    while (stream.read(buffer.data(), static_cast<std::streamsize>(buffer.size())),
           stream.gcount() > 0) {
        text.append(buffer.data(), static_cast<std::size_t>(stream.gcount()));
        if (text.size() > kMaxFileBytes)
            throw Error(fmt::format("{}: larger than {} MiB, expected a scene file", file.string(),
                                    kMaxFileBytes >> 20U));
    }
    if (stream.bad())
        throw Error(fmt::format("{}: cannot be read", file.string()));
    return text;
}

// ------------------------------------------------------------------------------- a scene to JSON

struct LightWriter {
    Members& out;

    void to_light(const LightField& field, const glm::dvec3& d) { out.triple(field.key, d); }
    void axis(const LightField& field, const glm::dvec3& d) { out.triple(field.key, d); }
    void position(const LightField& field, const glm::dvec3& p) { out.triple(field.key, p); }
    void number(const LightField& field, double value) { out.number(field.key, value); }
    void flag(const LightField& field, bool value) { out.raw(field.key, value ? "true" : "false"); }
    void edges(const LightField& field, const std::array<glm::dvec3, 2>& value)
    {
        out.pair(field.key, value);
    }
    void power(const LightField& field, const glm::vec3& value) { out.triple(field.key, value); }
};

std::string light_text(const Light& light, const std::string& place)
{
    Members out(place);
    out.text("type", light_name(light));
    visit_light(LightWriter{out}, light);
    return out.in_lines(kItemIndent);
}

std::string grid_medium_text(const GridMedium& medium, const std::string& place,
                             const fs::path& folder)
{
    Members out(place);
    out.text("type", "vdb");
    out.text("file", relative_name(medium.file, folder));
    if (!medium.grid.empty())
        out.text("grid", medium.grid);
    out.triple("translate", medium.translate);
    out.number("scale", medium.scale);
    out.triple("sigma_s_per_density", medium.sigma_s_per_density);
    out.triple("sigma_a_per_density", medium.sigma_a_per_density);
    out.number("g", medium.g);
    if (!medium.emission_grid.empty() || medium.emission_per_unit != glm::vec3(0)) {
        out.text("emission_grid", medium.emission_grid);
        out.triple("emission_per_unit", medium.emission_per_unit);
    }
    if (!medium.color_grid.empty())
        out.text("color_grid", medium.color_grid);
    if (!medium.temperature_grid.empty()) {
        out.text("temperature_grid", medium.temperature_grid);
        if (medium.temperature_scale != 0)
            out.number("temperature_scale", medium.temperature_scale);
        out.number("blackbody_intensity", medium.blackbody_intensity);
        out.triple("blackbody_tint", medium.blackbody_tint);
    }
    if (!medium.motion.velocity_grid.empty()) {
        out.text("velocity_grid", medium.motion.velocity_grid);
        out.text("velocity_unit",
                 std::string(velocity_units()[static_cast<std::size_t>(medium.motion.unit)]));
        out.number("shutter", medium.motion.shutter);
    }
    return out.in_lines(kItemIndent);
}

std::string box_medium_text(const BoxMedium& medium, const std::string& place)
{
    Members out(place);
    out.text("type", "box");
    out.triple("min", medium.min);
    out.triple("max", medium.max);
    const auto write =
        Overloaded{[&](const HomogeneousProfile&) { out.text("profile", "homogeneous"); },
                   [&](const ExpHeightProfile& falloff) {
                       out.text("profile", "exp_height");
                       out.number("scale_height", falloff.scale_height);
                       out.number("z0", falloff.z0);
                   },
                   [&](const NoiseProfile& noise) {
                       Members inner(place + ".noise");
                       inner.number("feature_size", noise.feature_size);
                       inner.number("octaves", noise.octaves);
                       inner.number("gain", noise.gain);
                       inner.number("lacunarity", noise.lacunarity);
                       inner.number("threshold", noise.threshold);
                       inner.number("seed", noise.seed);
                       inner.triple("drift_m_per_s", noise.drift);
                       out.text("profile", "noise");
                       out.raw("noise", inner.in_lines(kItemIndent +
                                                       std::string_view(R"({"noise": )").size()));
                   }};
    std::visit(write, medium.profile);
    out.triple("sigma_s", medium.sigma_s);
    out.triple("sigma_a", medium.sigma_a);
    out.number("g", medium.g);
    if (medium.emission != glm::vec3(0))
        out.triple("emission", medium.emission);
    return out.in_lines(kItemIndent);
}

template <typename SurfaceKind>
void add_material(Members& out, const SurfaceKind& surface, const FromMesh& missing = {})
{
    if (!missing.albedo)
        out.triple("albedo", surface.albedo);
    if (surface.gloss) {
        if (!missing.roughness)
            out.number("roughness", surface.gloss->roughness);
        if (!missing.metallic)
            out.number("metallic", surface.gloss->metallic);
    }
    if (missing.albedo ? !missing.emission : surface.emission != glm::vec3(0))
        out.triple("emission", surface.emission);
}

std::string surface_text(const Surface& surface, const std::string& place, const fs::path& folder)
{
    Members out(place);
    if (const auto* sphere = std::get_if<SphereSurface>(&surface)) {
        out.text("type", "sphere");
        out.triple("center", sphere->center);
        out.number("radius", sphere->radius);
        add_material(out, *sphere);
    } else if (const auto* box = std::get_if<BoxSurface>(&surface)) {
        out.text("type", "box");
        out.triple("min", box->min);
        out.triple("max", box->max);
        add_material(out, *box);
    } else {
        const auto& mesh = std::get<MeshSurface>(surface);
        out.text("type", "mesh");
        out.text("file", relative_name(mesh.file, folder));
        out.triple("translate", mesh.translate);
        out.number("scale", mesh.scale);
        add_material(out, mesh, mesh.from_mesh);
    }
    return out.in_lines(kItemIndent);
}

std::string probe_text(const LightProbe& probe, const std::string& place)
{
    Members out(place);
    out.triple("position", probe.position);
    out.number("radius", probe.radius);
    out.number("falloff", probe.falloff);
    out.text("parallax", std::string(kParallaxNames[static_cast<std::size_t>(probe.parallax)]));
    if (probe.parallax == LightProbe::Parallax::box) {
        out.triple("parallax_min", probe.parallax_min);
        out.triple("parallax_max", probe.parallax_max);
    }
    out.number("size", probe.size);
    return out.in_lines(kItemIndent);
}

void add_camera(Members& out, const Camera& camera)
{
    out.triple("position", camera.position);
    out.triple("look_at", camera.look_at);
    out.triple("up", camera.up);
    out.number("vfov_deg", camera.vfov_deg);
    out.number("near", camera.near);
    out.number("far", camera.far);
    out.text("projection",
             camera.projection == Camera::Projection::perspective ? "perspective" : "orthographic");
    if (camera.ortho_height != 0)
        out.number("ortho_height", camera.ortho_height);
}

std::string camera_text(const Scene& scene)
{
    if (scene.camera_path.empty()) {
        Members out("camera");
        add_camera(out, scene.camera);
        return out.in_lines(std::string_view(R"(  "camera": )").size());
    }
    std::vector<std::string> keys;
    for (std::size_t i = 0; i < scene.camera_path.size(); ++i) {
        Members out(fmt::format("camera[{}]", i));
        out.number("time", scene.camera_path[i].time);
        add_camera(out, scene.camera_path[i].camera);
        keys.push_back(out.in_lines(4));
    }
    return list_text(keys);
}

// ------------------------------------------------------------------------------- named files

std::string file_key(const std::string& file)
{
    std::error_code error;
    const fs::path canonical = fs::weakly_canonical(file, error);
    return error ? file : canonical.string();
}

// Reads each grid, mesh and map once, whoever asks for it.
class SceneFiles {
public:
    explicit SceneFiles(std::vector<std::string>& notes) : notes_(notes) {}

    void know(const std::string& file, const std::string& grid,
              const std::shared_ptr<const VoxelGrid>& loaded)
    {
        if (loaded && !file.empty())
            grids_.emplace(std::pair{file_key(file), grid}, loaded);
    }

    void know(const std::string& file, const std::shared_ptr<const TransparentImage>& loaded)
    {
        if (loaded && !file.empty())
            images_.emplace(file_key(file), loaded);
    }

    void know(const std::string& file, const std::shared_ptr<const Mesh>& loaded)
    {
        if (loaded && !file.empty())
            meshes_.emplace(file_key(file), loaded);
    }

    std::shared_ptr<const VoxelGrid> grid(const std::string& file, const std::string& name)
    {
        const std::string key = file_key(file);
        std::shared_ptr<const VoxelGrid>& slot = grids_[{key, name}];
        if (!slot) {
            LoadedGrid loaded = load_grid(file, name);
            for (std::string& note : loaded.notes)
                add_note(file, std::move(note));
            auto read = std::make_shared<const VoxelGrid>(std::move(loaded.grid));
            // "" and the name of the grid that it stands for share one copy.
            slot = read;
            slot = grids_.emplace(std::pair{key, read->name}, read).first->second;
        }
        return slot;
    }

    std::shared_ptr<const Mesh> mesh(const std::string& file)
    {
        std::shared_ptr<const Mesh>& slot = meshes_[file_key(file)];
        if (!slot)
            slot = std::make_shared<const Mesh>(load_mesh(file));
        for (const std::string& note : slot->notes)
            add_note(file, note);
        return slot;
    }

    std::shared_ptr<const TransparentImage> image(const std::string& file)
    {
        std::shared_ptr<const TransparentImage>& slot = images_[file_key(file)];
        if (!slot)
            slot = std::make_shared<const TransparentImage>(load_image(file));
        return slot;
    }

    void add_note(const std::string& file, std::string note)
    {
        const std::string name = fs::path(file).filename().string();
        if (!note.starts_with(file) && !note.starts_with(name))
            note = fmt::format("{}: {}", file, note);
        if (std::find(notes_.begin(), notes_.end(), note) == notes_.end())
            notes_.push_back(std::move(note));
    }

private:
    std::vector<std::string>& notes_;
    std::map<std::pair<std::string, std::string>, std::shared_ptr<const VoxelGrid>> grids_;
    std::map<std::string, std::shared_ptr<const Mesh>> meshes_;
    std::map<std::string, std::shared_ptr<const TransparentImage>> images_;
};

/// Chooses the scale of a temperature that states none, and says so.
void settle_temperature(GridMedium& medium, SceneFiles& files)
{
    if (!medium.temperature || medium.temperature->empty() || medium.temperature_scale != 0)
        return;
    medium.temperature_scale = kelvin_per_unit(medium);
    const auto most = static_cast<double>(medium.temperature->max_value);
    files.add_note(medium.file,
                   fmt::format("grid '{}' holds up to {:.4g}: taken as {}, {:.4g} K at most{} "
                               "(\"temperature_scale\": {})",
                               medium.temperature_grid, most,
                               medium.temperature_scale == 1 ? "kelvin" : "thousands of kelvin",
                               most * medium.temperature_scale,
                               glows_hot(medium) || medium.blackbody_intensity == 0
                                   ? ""
                                   : ", too cold to glow",
                               medium.temperature_scale));
}

/// What the scene leaves to the mesh's own material; a mesh without one stays as it is.
void settle_material(MeshSurface& surface)
{
    const FromMesh from = std::exchange(surface.from_mesh, {});
    if (surface.mesh == nullptr || !surface.mesh->material)
        return;
    const MeshMaterial& material = *surface.mesh->material;
    if (from.albedo) {
        surface.albedo = material.albedo;
        if (!surface.gloss)
            surface.gloss = material.gloss;
    }
    if (from.roughness)
        surface.gloss->roughness = material.gloss.roughness;
    if (from.metallic)
        surface.gloss->metallic = material.gloss.metallic;
    if (from.emission)
        surface.emission = material.emission;
}

bool is_blurred(const GridMedium& medium)
{
    return medium.motion.shutter > 0 && !medium.motion.velocity_grid.empty();
}

/// Spreads what was read of a medium along the way that it goes while the shutter is open.
void blur(GridMedium& medium, double frames_per_second)
{
    if (medium.density->empty() && (!medium.emission || medium.emission->empty()) &&
        (!medium.temperature || medium.temperature->empty()))
        return;
    const VoxelGrid velocity = load_vectors(medium.file, medium.motion.velocity_grid).grid;
    const bool in_voxels = medium.motion.unit == MediumMotion::Unit::voxels_per_frame;
    const Displacement displacement{
        &velocity, in_voxels ? medium.motion.shutter * glm::dmat3(velocity.world_from_index)
                             : glm::dmat3(medium.motion.shutter / frames_per_second)};
    const auto moved = [&](std::shared_ptr<const VoxelGrid>& grid, Kept kept) {
        if (grid)
            grid = std::make_shared<const VoxelGrid>(
                moved_grid(*grid, displacement, kept, medium.file));
    };
    if (medium.color)
        medium.color = std::make_shared<const VoxelGrid>(
            moved_color(*medium.color, *medium.density, displacement, medium.file));
    moved(medium.density, Kept::sum);
    moved(medium.emission, Kept::sum);
    moved(medium.temperature, Kept::fourth);
}

// A medium that a host filled in by hand names no file, and needs none.
void load_medium_files(GridMedium& medium, SceneFiles& files, double frames_per_second)
{
    if (medium.file.empty())
        return;
    const bool is_new = !medium.density;
    if (!medium.density)
        medium.density = files.grid(medium.file, medium.grid);
    if (!medium.emission && !medium.emission_grid.empty())
        medium.emission = files.grid(medium.file, medium.emission_grid);
    if (!medium.color && !medium.color_grid.empty()) {
        medium.color = files.grid(medium.file, medium.color_grid);
        if (medium.color->channels != 3)
            throw Error(fmt::format("{}: grid '{}' has one number a voxel, and a color_grid needs "
                                    "three (a vec3 grid, or name.x, name.y and name.z)",
                                    medium.file, medium.color_grid));
    }
    if (!medium.temperature && !medium.temperature_grid.empty()) {
        medium.temperature = files.grid(medium.file, medium.temperature_grid);
        if (medium.temperature->channels != 1)
            throw Error(fmt::format("{}: grid '{}' has three numbers a voxel, and a "
                                    "temperature_grid needs one",
                                    medium.file, medium.temperature_grid));
    }
    settle_temperature(medium, files);
    if (is_new && is_blurred(medium))
        blur(medium, frames_per_second);
}

}  // namespace

Scene parse_scene(const fs::path& file)
{
    return scene_from_json(read_text(file), file.string(), file.parent_path());
}

void load_scene_files(LoadedScene& loaded)
{
    SceneFiles files(loaded.notes);
    Scene& scene = loaded.scene;
    for (const Medium& medium : scene.media) {
        if (const auto* grid = std::get_if<GridMedium>(&medium); grid && !is_blurred(*grid)) {
            files.know(grid->file, grid->grid, grid->density);
            files.know(grid->file, grid->emission_grid, grid->emission);
            files.know(grid->file, grid->color_grid, grid->color);
            files.know(grid->file, grid->temperature_grid, grid->temperature);
        }
    }
    for (const Surface& surface : scene.surfaces) {
        if (const auto* mesh = std::get_if<MeshSurface>(&surface))
            files.know(mesh->file, mesh->mesh);
    }
    bool any_picture = !scene.world.environment && !scene.world.environment_file.empty();
    for (const Transparent& transparent : scene.transparents) {
        const TransparentLook& look = look_of(transparent);
        any_picture |= !look.image && !look.image_file.empty();
        files.know(look.image_file, look.image);
        if (const auto* mesh = std::get_if<MeshTransparent>(&transparent))
            files.know(mesh->file, mesh->mesh);
    }
    if (any_picture)
        pictures::open_ahead();

    for (Medium& medium : scene.media) {
        if (auto* grid = std::get_if<GridMedium>(&medium))
            load_medium_files(*grid, files, scene.frames_per_second);
    }
    for (Surface& surface : scene.surfaces) {
        auto* mesh = std::get_if<MeshSurface>(&surface);
        if (mesh != nullptr && !mesh->mesh && !mesh->file.empty())
            mesh->mesh = files.mesh(mesh->file);
        if (mesh != nullptr)
            settle_material(*mesh);
    }
    for (Transparent& transparent : scene.transparents) {
        TransparentLook& look = look_of(transparent);
        if (!look.image && !look.image_file.empty())
            look.image = files.image(look.image_file);
        auto* mesh = std::get_if<MeshTransparent>(&transparent);
        if (mesh != nullptr && !mesh->mesh && !mesh->file.empty())
            mesh->mesh = files.mesh(mesh->file);
    }
    if (!scene.world.environment && !scene.world.environment_file.empty())
        scene.world.environment =
            std::make_shared<const Environment>(load_environment(scene.world.environment_file));
}

LoadedScene load_scene(const fs::path& file)
{
    LoadedScene loaded;
    loaded.scene = parse_scene(file);
    load_scene_files(loaded);
    return loaded;
}

std::string scene_to_json(const Scene& scene, const fs::path& folder)
{
    Members top("");
    top.raw("resolution", fmt::format("[{}, {}]", scene.resolution.x, scene.resolution.y));
    top.raw("camera", camera_text(scene));
    if (scene.world.environment_file.empty()) {
        top.triple("world_radiance", scene.world.radiance);
    } else {
        Members world("world_radiance");
        world.text("environment", relative_name(scene.world.environment_file, folder));
        world.number("scale", scene.world.environment_scale);
        top.raw("world_radiance", world.in_lines(2));
    }
    if (scene.time != 0)
        top.number("time", scene.time);
    if (scene.frames_per_second != Scene{}.frames_per_second)
        top.number("frames_per_second", scene.frames_per_second);

    std::vector<std::string> items;
    for (std::size_t i = 0; i < scene.lights.size(); ++i)
        items.push_back(light_text(scene.lights[i], fmt::format("lights[{}]", i)));
    top.raw("lights", list_text(items));
    items.clear();
    for (std::size_t i = 0; i < scene.media.size(); ++i) {
        const std::string place = fmt::format("media[{}]", i);
        items.push_back(std::visit(
            Overloaded{
                [&](const GridMedium& grid) { return grid_medium_text(grid, place, folder); },
                [&](const BoxMedium& box) { return box_medium_text(box, place); }},
            scene.media[i]));
    }
    top.raw("media", list_text(items));
    items.clear();
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i)
        items.push_back(surface_text(scene.surfaces[i], fmt::format("surfaces[{}]", i), folder));
    top.raw("surfaces", list_text(items));
    if (!scene.transparents.empty()) {
        items.clear();
        for (std::size_t i = 0; i < scene.transparents.size(); ++i)
            items.push_back(transparent_text(scene.transparents[i],
                                             fmt::format("transparents[{}]", i), folder));
        top.raw("transparents", list_text(items));
    }
    if (!scene.probes.empty()) {
        items.clear();
        for (std::size_t i = 0; i < scene.probes.size(); ++i)
            items.push_back(probe_text(scene.probes[i], fmt::format("probes[{}]", i)));
        top.raw("probes", list_text(items));
    }

    std::string text = fmt::format("{{\n  {}\n}}\n", fmt::join(top.list(), ",\n  "));
    // A host may have filled in what no file may say; better told now than when it is read.
    scene_from_json(text, "the scene cannot be written", folder);
    return text;
}

void save_scene(const Scene& scene, const fs::path& file)
{
    write::write_whole(file, scene_to_json(scene, file.parent_path()));
}

}  // namespace fumarole::asset
