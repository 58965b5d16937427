// SPDX-License-Identifier: Apache-2.0
// Of very many objects that move together, some stand for what all of them reflect.
#include "patches/dynamic_reflection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>

#include "base/random.h"

namespace gnomon::patches {
namespace {

using Measured = DynamicReflection::Measured;
using Chosen = DynamicReflection::Chosen;

std::vector<Measured> objects_of(std::size_t count, double& all)
{
    Random random(7);
    std::vector<Measured> objects;
    all = 0;
    for (scene::ObjectId o = 0; o < count; ++o) {
        const auto number = [&] { return static_cast<float>(random.next() % 1000) / 100; };
        const glm::mat4 matrix = glm::translate(glm::mat4(1), glm::vec3(number(), number(), number()));
        objects.push_back({matrix, o, o % 100 == 0 ? 50.0 : 0.01 + static_cast<double>(number())});
        all += objects.back().area;
    }
    return objects;
}

TEST(DynamicReflection, TheChosenObjectsHaveTheAreaOfAll)
{
    double all = 0;
    const std::vector<Measured> objects = objects_of(5000, all);
    const std::vector<Chosen> chosen = DynamicReflection::choose_objects(objects, all);
    std::size_t places = 0;
    double area = 0, large = 0, large_of_all = 0;
    for (const Chosen& one : chosen) {
        places += one.places;
        area += one.weight * objects[one.object].area;
        if (objects[one.object].area == 50) large += one.weight * 50;
    }
    for (const Measured& of : objects)
        if (of.area == 50) large_of_all += 50;
    EXPECT_EQ(places, 1024u);
    EXPECT_LT(chosen.size(), 1024u) << "a large object has several places";
    EXPECT_NEAR(area, all, 1e-9 * all);
    EXPECT_NEAR(large, large_of_all, 0.05 * large_of_all) << "large and small objects have their shares";
}

TEST(DynamicReflection, TheChoiceDoesNotDependOnTheNumbersOfObjects)
{
    double all = 0;
    std::vector<Measured> objects = objects_of(3000, all);
    const std::vector<Chosen> chosen = DynamicReflection::choose_objects(objects, all);
    std::ranges::reverse(objects);
    const std::vector<Chosen> again = DynamicReflection::choose_objects(objects, all);
    ASSERT_EQ(chosen.size(), again.size());
    for (std::size_t i = 0; i < chosen.size(); ++i) {
        EXPECT_EQ(chosen[i].object, again[i].object);
        EXPECT_EQ(chosen[i].weight, again[i].weight);
    }
}

TEST(FacingPlaces, AreSearchedAsByAPlainLoop)
{
    Random random(12);
    // Places repeat, so that several are equally near.
    const auto coordinate = [&] { return static_cast<float>(random.next() % 5); };
    const auto direction = [&] {
        return glm::normalize(glm::vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(0.1f, 1)));
    };
    std::vector<std::pair<glm::vec3, glm::vec3>> plain;
    FacingPlaces places;
    for (int i = 0; i < 203; ++i) {
        plain.emplace_back(glm::vec3(coordinate(), coordinate(), coordinate()), direction());
        places.push(plain.back().first, plain.back().second);
    }
    int found = 0, repeated = 0;
    for (int round = 0; round < 400; ++round) {
        const std::uint32_t first = random.next() % 203, last = first + random.next() % (204 - first);
        const glm::vec3 p(coordinate(), coordinate(), coordinate()),
            normal = round % 9 == 0 ? -direction() : direction();
        float least = k_infinity;
        std::vector<std::uint32_t> nearest;
        for (std::uint32_t k = first; k < last; ++k) {
            if (!(glm::dot(plain[k].second, normal) > FacingPlaces::k_same_facing)) continue;
            const float square = glm::dot(plain[k].first - p, plain[k].first - p);
            if (square < least) least = square, nearest.clear();
            if (square == least) nearest.push_back(k);
        }
        ASSERT_EQ(places.least(first, last, p, normal), least);
        std::vector<std::uint32_t> listed;
        for (std::uint32_t k = places.next(first, last, p, normal, least); k < last;
             k = places.next(k + 1, last, p, normal, least))
            listed.push_back(k);
        ASSERT_EQ(listed, nearest);
        found += !nearest.empty(), repeated += nearest.size() > 1;
    }
    EXPECT_GT(found, 200);
    EXPECT_GT(repeated, 50);
}

}   // namespace
}   // namespace gnomon::patches
