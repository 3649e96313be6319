"""One small model in each format that assimp reads: a unit square in the file's own xy plane, facing +z, of two
triangles (STL: one), red (0.8, 0.1, 0.2) where the format has materials."""

from __future__ import annotations

import io
import struct
import zipfile

CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))
FLAT = " ".join(f"{x} {y} {z}" for x, y, z in CORNERS)

OFF = "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n"
STL = ("solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
       "endsolid x\n")  # fmt: skip


def ply(colors: bool = False, faces: str = "4 0 1 2 3", corners=CORNERS) -> str:
    """Colours, when asked for, are 188 in all channels: sRGB for 0.5029."""
    more = "".join(f"property uchar {name}\n" for name in ("red", "green", "blue")) if colors else ""
    points = "".join(f"{x} {y} {z}{' 188 188 188' if colors else ''}\n" for x, y, z in corners)
    lines = faces.split("\n")
    axes = "".join(f"property float {axis}\n" for axis in "xyz")
    head = f"ply\nformat ascii 1.0\nelement vertex {len(corners)}\n{axes}{more}"
    return f"{head}element face {len(lines)}\nproperty list uchar int vertex_indices\nend_header\n{points}{faces}\n"


AC = ('AC3Db\nMATERIAL "red" rgb 0.8 0.1 0.2 amb 0.2 0.2 0.2 emis 0 0 0 spec 0.02 0.02 0.02 shi 6 trans 0\n'
      'OBJECT world\nkids 1\nOBJECT poly\nname "quad"\nnumvert 4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\nnumsurf 1\nSURF 0x20\n'
      "mat 0\nrefs 4\n0 0 0\n1 1 0\n2 1 1\n3 0 1\nkids 0\n")  # fmt: skip

# The .x format is left-handed: seen from where z grows its front faces run counter-clockwise, as ours do.
X = ("xof 0303txt 0032\nMesh quad {\n 4;\n 0;0;0;,\n 1;0;0;,\n 1;1;0;,\n 0;1;0;;\n 1;\n 4;3,2,1,0;;\n"
     " MeshMaterialList {\n 1;\n 1;\n 0;\n Material red {\n 0.8;0.1;0.2;1.0;;\n 6.0;\n 0.02;0.02;0.02;;\n"
     " 0.0;0.0;0.0;;\n }\n }\n}\n")  # fmt: skip

X3D = ('<?xml version="1.0"?><X3D version="3.0" profile="Interchange"><Scene><Transform><Shape><Appearance>'
       '<Material diffuseColor="0.8 0.1 0.2" specularColor="0.02 0.02 0.02" shininess="0.046875"/></Appearance>'
       f'<IndexedFaceSet coordIndex="0 1 2 3 -1"><Coordinate point="{FLAT}"/></IndexedFaceSet></Shape></Transform>'
       "</Scene></X3D>")  # fmt: skip

ASE = """*3DSMAX_ASCIIEXPORT	200
*MATERIAL_LIST {
	*MATERIAL_COUNT 1
	*MATERIAL 0 {
		*MATERIAL_NAME "red"
		*MATERIAL_DIFFUSE 0.8 0.1 0.2
	}
}
*GEOMOBJECT {
	*NODE_NAME "quad"
	*NODE_TM {
		*NODE_NAME "quad"
		*TM_ROW0 1 0 0
		*TM_ROW1 0 1 0
		*TM_ROW2 0 0 1
		*TM_ROW3 0 0 0
	}
	*MESH {
		*MESH_NUMVERTEX 4
		*MESH_NUMFACES 2
		*MESH_VERTEX_LIST {
			*MESH_VERTEX 0 0 0 0
			*MESH_VERTEX 1 1 0 0
			*MESH_VERTEX 2 1 1 0
			*MESH_VERTEX 3 0 1 0
		}
		*MESH_FACE_LIST {
			*MESH_FACE 0: A: 0 B: 1 C: 2 AB: 1 BC: 1 CA: 0 *MESH_SMOOTHING 1 *MESH_MTLID 0
			*MESH_FACE 1: A: 0 B: 2 C: 3 AB: 0 BC: 1 CA: 1 *MESH_SMOOTHING 1 *MESH_MTLID 0
		}
	}
	*MATERIAL_REF 0
}
"""


def _source(name: str, values: str, count: int, axes: str) -> str:
    params = "".join(f'<param name="{axis}" type="float"/>' for axis in axes)
    return (f'<source id="{name}"><float_array id="{name}a" count="{count * len(axes)}">{values}</float_array>'
            f'<technique_common><accessor source="#{name}a" count="{count}" stride="{len(axes)}">{params}</accessor>'
            "</technique_common></source>")  # fmt: skip


def dae(diffuse: str = "<color>0.8 0.1 0.2 1</color>", up: str = "Y_UP", metres: float = 1.0, nodes: str = "") -> str:
    """Collada; `nodes` replaces the one node that shows the square."""
    shown = ('<instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="s" target="#m"/>'
             "</technique_common></bind_material></instance_geometry>")  # fmt: skip
    nodes = (nodes or '<node id="n" name="quad">SHOWN</node>').replace("SHOWN", shown)
    return (
        '<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">'
        f'<asset><unit name="u" meter="{metres}"/><up_axis>{up}</up_axis></asset>'
        '<library_images><image id="img"><init_from>wood.png</init_from></image></library_images>'
        '<library_effects><effect id="fx"><profile_COMMON>'
        '<newparam sid="s"><surface type="2D"><init_from>img</init_from></surface></newparam>'
        '<newparam sid="t"><sampler2D><source>s</source></sampler2D></newparam>'
        f'<technique sid="c"><phong><diffuse>{diffuse}</diffuse><specular><color>0.02 0.02 0.02 1</color></specular>'
        "<shininess><float>6</float></shininess></phong></technique></profile_COMMON></effect></library_effects>"
        '<library_materials><material id="m" name="red"><instance_effect url="#fx"/></material></library_materials>'
        '<library_geometries><geometry id="g" name="quad"><mesh>'
        + _source("p", FLAT, 4, "XYZ") + _source("u", "0 0 1 0 1 1 0 1", 4, "ST")
        + '<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>'
        '<polylist material="s" count="1"><input semantic="VERTEX" source="#v" offset="0"/>'
        '<input semantic="TEXCOORD" source="#u" offset="1" set="0"/><vcount>4</vcount><p>0 0 1 1 2 2 3 3</p></polylist>'
        f'</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="sc">{nodes}</visual_scene>'
        '</library_visual_scenes><scene><instance_visual_scene url="#sc"/></scene></COLLADA>'
    )  # fmt: skip


_FBX_OBJECTS = """Objects:  {
	Geometry: 100, "Geometry::quad", "Mesh" {
		Vertices: *12 {
			a: POINTS
		}
		PolygonVertexIndex: *4 {
			a: 0,1,2,-4
		}
		GeometryVersion: 124
		LayerElementMaterial: 0 {
			Version: 101
			Name: ""
			MappingInformationType: "AllSame"
			ReferenceInformationType: "IndexToDirect"
			Materials: *1 {
				a: 0
			}
		}
		Layer: 0 {
			Version: 100
			LayerElement:  {
				Type: "LayerElementMaterial"
				TypedIndex: 0
			}
		}
	}
	Model: 200, "Model::quad", "Mesh" {
		Version: 232
	}
	Material: 300, "Material::red", "" {
		Version: 102
		ShadingModel: "phong"
		Properties70:  {
			P: "DiffuseColor", "Color", "", "A",0.8,0.1,0.2
			P: "SpecularColor", "Color", "", "A",0.02,0.02,0.02
			P: "ShininessExponent", "Number", "", "A",6
		}
	}
}
Connections:  {
	C: "OO",200,0
	C: "OO",100,200
	C: "OO",300,200
}
"""


def fbx(up: int = 1, centimetres: float = 100.0) -> str:
    """The text form of FBX 7.3. up: 1 for y, 2 for z. centimetres: UnitScaleFactor."""
    front, sign = (2, 1) if up == 1 else (1, -1)
    settings = {"UpAxis": up, "UpAxisSign": 1, "FrontAxis": front, "FrontAxisSign": sign, "CoordAxis": 0,
                "CoordAxisSign": 1}  # fmt: skip
    axes = "".join(f'\t\tP: "{name}", "int", "Integer", "",{value}\n' for name, value in settings.items())
    points = ",".join(str(v) for corner in CORNERS for v in corner)
    return f"""; FBX 7.3.0 project file
FBXHeaderExtension:  {{
	FBXHeaderVersion: 1003
	FBXVersion: 7300
}}
GlobalSettings:  {{
	Version: 1000
	Properties70:  {{
{axes}		P: "UnitScaleFactor", "double", "Number", "",{centimetres}
	}}
}}
""" + _FBX_OBJECTS.replace("POINTS", points)


def three_ds() -> bytes:
    """3D Studio: chunks of a 16-bit kind and a 32-bit length."""

    def chunk(kind: int, body: bytes) -> bytes:
        return struct.pack("<HI", kind, 6 + len(body)) + body

    points = struct.pack("<H12f", 4, *(v for corner in CORNERS for v in corner))
    faces = struct.pack("<H8H", 2, 0, 1, 2, 7, 0, 2, 3, 7) + chunk(0x4130, b"red\0" + struct.pack("<HHH", 2, 0, 1))
    material = chunk(0xAFFF, chunk(0xA000, b"red\0") + chunk(0xA020, chunk(0x0010, struct.pack("<3f", 0.8, 0.1, 0.2))))
    thing = chunk(0x4000, b"quad\0" + chunk(0x4100, chunk(0x4110, points) + chunk(0x4120, faces)))
    return chunk(0x4D4D, chunk(0x3D3D, material + thing))


def lwo() -> bytes:
    """LightWave object: IFF chunks, left-handed, front faces clockwise."""

    def chunk(kind: bytes, body: bytes, length: str = ">I") -> bytes:
        return kind + struct.pack(length, len(body)) + body + b"\0" * (len(body) % 2)

    points = struct.pack(">12f", *(v for corner in CORNERS for v in corner))
    red = chunk(b"COLR", struct.pack(">3fH", 0.8, 0.1, 0.2, 0), ">H")
    body = (b"LWO2" + chunk(b"TAGS", b"red\0") + chunk(b"LAYR", struct.pack(">HH3f", 0, 0, 0, 0, 0) + b"quad\0\0")
            + chunk(b"PNTS", points) + chunk(b"POLS", b"FACE" + struct.pack(">H4H", 4, 0, 3, 2, 1)[:10])
            + chunk(b"PTAG", b"SURF" + struct.pack(">HH", 0, 0)) + chunk(b"SURF", b"red\0\0\0" + red))  # fmt: skip
    return chunk(b"FORM", body)


def ms3d() -> bytes:
    """MilkShape 3D, version 4."""
    data = b"MS3D000000" + struct.pack("<iH", 4, 4)
    for corner in CORNERS:
        data += struct.pack("<B3fbB", 0, *corner, -1, 0)
    data += struct.pack("<H", 2)
    for triangle in ((0, 1, 2), (0, 2, 3)):
        data += struct.pack("<H3H9f3f3fBB", 0, *triangle, *((0, 0, 1) * 3), 0, 0, 0, 0, 0, 0, 1, 0)
    data += struct.pack("<HB32sH2Hb", 1, 0, b"quad", 2, 0, 1, 0)
    colors = (*(0.2,) * 4, 0.8, 0.1, 0.2, 1.0, 0.02, 0.02, 0.02, 1.0, 0.0, 0.0, 0.0, 1.0)
    data += struct.pack("<H32s16fffB128s128s", 1, b"red", *colors, 6.0, 1.0, 0, b"", b"")
    return data + struct.pack("<ffiH", 24.0, 0.0, 0, 0)


def three_mf() -> bytes:
    """3D Manufacturing Format: XML in a ZIP archive."""
    package = "http://schemas.openxmlformats.org/package/2006"
    kind = "application/vnd.ms-package.3dmanufacturing-3dmodel"
    relation = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
    core = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
    vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in CORNERS)
    triangles = '<triangle v1="0" v2="1" v3="2"/><triangle v1="0" v2="2" v3="3"/>'
    files = {
        "[Content_Types].xml": f'<Types xmlns="{package}/content-types">'
        f'<Default Extension="model" ContentType="{kind}+xml"/></Types>',
        "_rels/.rels": f'<Relationships xmlns="{package}/relationships">'
        f'<Relationship Target="/3D/3dmodel.model" Id="rel0" Type="{relation}"/></Relationships>',
        "3D/3dmodel.model": f'<model unit="millimeter" xmlns="{core}"><resources><object id="1" type="model"><mesh>'
        f"<vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh></object></resources>"
        '<build><item objectid="1"/></build></model>',
    }
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, text in files.items():
            archive.writestr(zipfile.ZipInfo(name), f'<?xml version="1.0"?>{text}')  # without the time of day
    return stream.getvalue()


FILES: dict[str, str | bytes] = {
    ".ply": ply(), ".stl": STL, ".off": OFF, ".3mf": three_mf(), ".fbx": fbx(), ".dae": dae(), ".3ds": three_ds(),
    ".ase": ASE, ".lwo": lwo(), ".x": X, ".x3d": X3D, ".ms3d": ms3d(), ".ac": AC,
}  # fmt: skip
