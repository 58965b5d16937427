// SPDX-License-Identifier: Apache-2.0
#include "scene/defaults/framing.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "base/random.h"
#include "io/load.h"
#include "scene/defaults/default_view.h"
#include "scene/state.h"
#include "scene/view.h"
#include "support.h"

namespace gnomon::scene {
namespace {

// Moves from the origin to `there` in one second.
class Straight : public TransformTrack {
 public:
    explicit Straight(const glm::dvec3& there) : there_(there) {}
    glm::dmat4 evaluate(double time) const override
    {
        glm::dmat4 result(1);
        result[3] = glm::dvec4(std::clamp(time, 0.0, 1.0) * there_, 1);
        return result;
    }
    std::vector<Interval> changing() const override { return {{0, 1}}; }

 private:
    glm::dvec3 there_;
};

// A static cloud of triangles, and one that moves `there`.
Scene clouds(std::uint64_t seed, const glm::dvec3& there)
{
    Random random(seed);
    Scene scene;
    scene.materials.emplace_back();
    Mesh mesh;
    const glm::vec3 size(random.uniform(0.2f, 4), random.uniform(0.2f, 4), random.uniform(0.2f, 4));
    for (std::uint32_t i = 0; i < 30; ++i)
        mesh.positions.push_back(size * glm::vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)));
    for (std::uint32_t i = 0; i < 30; i += 3) mesh.triangles.emplace_back(i, i + 1, i + 2);
    mesh.parts = {{0, 0, 10}};
    scene.meshes.push_back(mesh);
    scene.add_node("still", none);
    scene.add_node("goes", none);
    scene.nodes[0].mesh = scene.nodes[1].mesh = 0;
    scene.nodes[1].transform = std::make_shared<Straight>(there);
    scene.timeline.end = 1;
    scene.finish();
    return scene;
}

// The fraction of the image's half width and half height that the vertices reach at a time; infinite behind the
// eye.
glm::dvec2 reach(const Scene& scene, const FramingOptions& options, const glm::dvec3& eye, double time, double aspect)
{
    const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), options.back));
    const glm::dvec3 up = glm::cross(options.back, right);
    const double tangent = std::tan(options.vertical_fov / 2);
    glm::dvec2 most(0);
    for (const Object& object : scene.objects) {
        for (const glm::vec3& p : scene.meshes[object.mesh].positions) {
            const glm::dvec3 to = transform_point(scene.world_matrix(object.node, time), glm::dvec3(p)) - eye;
            const double depth = -glm::dot(to, options.back);
            if (depth <= 0) return glm::dvec2(1e9);
            most.x = std::max(most.x, std::abs(glm::dot(to, right)) / (depth * tangent * aspect));
            most.y = std::max(most.y, std::abs(glm::dot(to, up)) / (depth * tangent));
        }
    }
    return most;
}

FramingOptions from_the_right()
{
    FramingOptions options;
    options.back = glm::normalize(glm::dvec3(0.55, 0.36, 1.0));
    return options;
}

TEST(Framing, SceneStaysInTheImageAndFillsItAtAllTimes)
{
    const FramingOptions options = from_the_right();
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        const Scene scene = clouds(seed, {0.7, 1.2, -0.4});
        const Framed framed = frame_clip(scene, options);
        for (const double aspect : {0.4, 1.0, 4.0 / 3, 16.0 / 9, 3.0}) {
            glm::dvec2 most(0);
            for (int look = 0; look < options.looks; ++look) {
                const double time = static_cast<double>(look) / (options.looks - 1);
                most = glm::max(most, reach(scene, options, framed.eye(aspect), time, aspect));
            }
            EXPECT_LE(std::max(most.x, most.y), 1.0) << seed << " " << aspect;
            // In a wide image, the nearest point may keep the camera away.
            if (aspect < 2) {
                EXPECT_NEAR(std::max(most.x, most.y), 1 / options.margin, 1e-3) << seed << " " << aspect;
            }
        }
        EXPECT_GT(framed.size, 0);
    }
}

// As far from one edge as from the opposite one, in both directions, and at any aspect.
TEST(Framing, TheClipIsInTheMiddleOfTheImage)
{
    const FramingOptions options = from_the_right();
    const glm::dmat3 axes = camera_axes(options.back);
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        const Scene scene = clouds(seed, {0.7, 1.2, -0.4});
        const Framed framed = frame_clip(scene, options);
        for (const double aspect : {0.4, 1.0, 16.0 / 9, 3.0}) {
            const glm::dvec3 eye = framed.eye(aspect);
            glm::dvec2 least(1e9), most(-1e9);
            for (int look = 0; look < options.looks; ++look)
                for (const Object& object : scene.objects) {
                    const double time = static_cast<double>(look) / (options.looks - 1);
                    const glm::dmat4 world = scene.world_matrix(object.node, time);
                    for (const glm::vec3& p : scene.meshes[object.mesh].positions) {
                        const glm::dvec3 to = glm::transpose(axes) * (transform_point(world, glm::dvec3(p)) - eye);
                        least = glm::min(least, glm::dvec2(to) / -to.z);
                        most = glm::max(most, glm::dvec2(to) / -to.z);
                    }
                }
            EXPECT_NEAR(least.x + most.x, 0, 1e-5 * (most.x - least.x)) << seed << " " << aspect;
            EXPECT_NEAR(least.y + most.y, 0, 1e-5 * (most.y - least.y)) << seed << " " << aspect;
        }
    }
}

TEST(Framing, DistantObjectsDoNotShrinkTheRest)
{
    const FramingOptions options = from_the_right();
    const Scene scene = clouds(3, {400, 0, 0});
    const Framed framed = frame_clip(scene, options);
    const glm::dvec2 most = reach(scene, options, framed.eye(1.5), 0, 1.5);
    EXPECT_NEAR(std::max(most.x, most.y), 1 / options.margin, 1e-3);
    EXPECT_LT(framed.size, 20);
}

// Whether all vertices of a scene are in view at a time.
bool is_whole(const SceneState& state, const View& view)
{
    for (ObjectId id = 0; id < state.scene().objects.size(); ++id) {
        if (!state.object_visible(id)) continue;
        const Object& object = state.scene().objects[id];
        const Mesh& mesh = state.scene().meshes[object.mesh];
        const std::vector<glm::vec3>& positions = object.deforming ? state.deformed(id).positions : mesh.positions;
        const glm::mat4 world = state.object_matrix(id);
        for (const glm::uvec3& triangle : mesh.triangles)
            for (int i = 0; i < 3; ++i) {
                const glm::vec3 to = transform_point(world, positions[triangle[i]]) - view.eye;
                const float depth = glm::dot(to, view.forward);
                if (!(depth > 0) || std::abs(glm::dot(to, view.right)) > depth * glm::dot(view.right, view.right) ||
                    std::abs(glm::dot(to, view.up)) > depth * glm::dot(view.up, view.up))
                    return false;
            }
    }
    return true;
}

// Each scene file that gets a camera from outside is whole in its images, from the first frame to the last.
TEST(FramingFull, SceneFilesAreWholeInTheirDefaultImages)
{
    GNOMON_NEED_SCENE(folder, "real");
    std::vector<std::filesystem::path> files;
    for (const char* name : {"real", "gltf"})
        for (const auto& entry : std::filesystem::recursive_directory_iterator(test::scenes() / name))
            if (entry.path().extension() == ".gltf" || entry.path().extension() == ".glb")
                files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    int seen = 0;
    for (const std::filesystem::path& file : files) {
        std::shared_ptr<const Scene> scene;
        try {
            scene = std::make_shared<const Scene>(io::load_scene(file));
        } catch (const Error&) {
            continue;
        }
        if (!scene->cameras.empty() || scene->objects.empty()) continue;
        SceneState state(scene, scene->timeline.start);
        const DefaultView chosen = choose_view(state, {});
        if (chosen.room) continue;
        ++seen;
        glm::dmat4 node(chosen.axes);
        node[3] = glm::dvec4(chosen.eye, 1);
        const double length = scene->timeline.end - scene->timeline.start;
        for (const Size size : {Size{1280, 720}, Size{512, 512}, Size{300, 500}}) {
            const View view = make_view(chosen.camera, node, size);
            EXPECT_TRUE(is_whole(SceneState(scene, scene->timeline.start), view)) << file << " " << size.width;
            // A clip that goes far is framed as it begins.
            int cropped = 0;
            for (int k = 1; k <= 12 && length > 0; ++k)
                cropped += !is_whole(SceneState(scene, scene->timeline.start + length * k / 12), view);
            if (cropped > 0) std::printf("%s: %d of 12 later moments are cropped\n", file.c_str(), cropped);
        }
    }
    EXPECT_GT(seen, 0);
}

TEST(Framing, HandlesEmptyAndPointScenes)
{
    const Framed nothing = frame_clip(Scene(), from_the_right());
    EXPECT_TRUE(is_finite(glm::vec3(nothing.eye(1))));
    EXPECT_GT(glm::length(nothing.eye(1)), 1);
    Scene point;
    point.materials.emplace_back();
    Mesh mesh;
    mesh.positions.assign(3, {5, 6, 7});
    mesh.triangles.emplace_back(0, 1, 2);
    mesh.parts = {{0, 0, 1}};
    point.meshes.push_back(mesh);
    point.add_node("", none);
    point.nodes[0].mesh = 0;
    point.finish();
    const Framed framed = frame_clip(point, from_the_right());
    EXPECT_TRUE(is_finite(glm::vec3(framed.eye(1))));
    EXPECT_GT(framed.size, 0);
}

}   // namespace
}   // namespace gnomon::scene
