// SPDX-License-Identifier: Apache-2.0
#include "scene/face_tree.h"

#include <algorithm>
#include <numeric>

namespace gnomon::scene {

namespace {

glm::vec3 middle(const SizedFace& face)
{
    glm::vec3 sum(0);
    for (int i = 0; i < face.corners; ++i) sum += face.corner[static_cast<std::size_t>(i)];
    return sum / static_cast<float>(face.corners);
}

class Maker {
 public:
    explicit Maker(std::span<const SizedFace> faces) : faces_(faces)
    {
        tree_.order.resize(faces.size());
        std::iota(tree_.order.begin(), tree_.order.end(), 0u);
        tree_.nodes.reserve(2 * faces.size() / FaceTree::k_leaf + 1);
        for (const SizedFace& face : faces) middles_.push_back(middle(face));
    }
    FaceTree make()
    {
        add(0, faces_.size());
        return std::move(tree_);
    }

 private:
    void add(std::size_t begin, std::size_t end)
    {
        const std::size_t at = tree_.nodes.size();
        tree_.nodes.push_back(node(begin, end));
        if (end - begin <= FaceTree::k_leaf) {
            tree_.nodes[at].first = static_cast<std::uint32_t>(begin);
            tree_.nodes[at].count = static_cast<std::uint32_t>(end - begin);
        } else {
            const std::size_t half = split(begin, end);
            add(begin, half);
            add(half, end);
        }
        tree_.nodes[at].next = static_cast<std::uint32_t>(tree_.nodes.size());
    }

    // Splits the longest axis at the median of the faces' places.
    std::size_t split(std::size_t begin, std::size_t end)
    {
        Box3 box;
        for (std::size_t i = begin; i < end; ++i) box.add(middles_[tree_.order[i]]);
        const glm::vec3 size = box.size();
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        std::stable_sort(tree_.order.begin() + static_cast<std::ptrdiff_t>(begin),
                         tree_.order.begin() + static_cast<std::ptrdiff_t>(end),
                         [&](std::uint32_t a, std::uint32_t b) { return middles_[a][axis] < middles_[b][axis]; });
        return (begin + end) / 2;
    }

    FaceNode node(std::size_t begin, std::size_t end) const
    {
        FaceNode node;
        Box3 box;
        glm::vec3 normals(0);
        for (std::size_t i = begin; i < end; ++i) {
            const SizedFace& face = faces_[tree_.order[i]];
            for (int k = 0; k < face.corners; ++k) box.add(face.corner[static_cast<std::size_t>(k)]);
            normals += luminance(face.radiance) * face.area * face.normal;
        }
        node.centre = box.centre();
        node.two_sided = faces_[tree_.order[begin]].two_sided;
        const float length = glm::length(normals);
        if (length > 0) node.normal = normals / length;
        float least = 1;
        for (std::size_t i = begin; i < end; ++i) {
            const SizedFace& face = faces_[tree_.order[i]];
            for (int k = 0; k < face.corners; ++k)
                node.radius =
                    std::max(node.radius, glm::length(face.corner[static_cast<std::size_t>(k)] - node.centre));
            const float cosine = glm::dot(face.normal, node.normal);
            least = std::min(least, face.two_sided == node.two_sided ? cosine : -1.0f);
            node.area += face.area * cosine;
            node.power += face.radiance * (face.area * cosine);
        }
        if (least > 0) node.normal_spread = std::sqrt(std::max(0.0f, 1 - least * least));
        return node;
    }

    std::span<const SizedFace> faces_;
    std::vector<glm::vec3> middles_;   // by face
    FaceTree tree_;
};

}   // namespace

FaceTree make_face_tree(std::span<const SizedFace> faces)
{
    return faces.size() < FaceTree::k_fewest ? FaceTree{} : Maker(faces).make();
}

}   // namespace gnomon::scene
