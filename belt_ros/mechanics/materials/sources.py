"""Where the figures of the material presets come from, and how each document was consulted.

A title ends with what was taken from it. Second-hand quotations name who quotes.
"""

from belt_ros.mechanics.materials.ranges import Evidence, Source

GATES_FLAT = Source(
    "gates-flat",
    "Gates Mectrol, Flat Belt Specifications F8 to FX12 (web page): specific stiffness, mass, "
    "greatest tension, friction of urethane and polyamide on steel, temperatures",
    Evidence.READ,
)
ESBAND = Source(
    "esband",
    "Schlatterer, Esband production programme 2008: elongation of endless belts against axle load "
    "(two strands: halved here), pre-tension, temperatures, friction by pulley material (+-0.1)",
    Evidence.READ,
)
HABASIT_HAT8P = Source(
    "habasit-hat8p",
    "Habasit, product data sheet HAT-8P (2005): polyamide fabric belt, k1% static 7 and relaxed "
    "2.4 N/mm, 2.0 mm, 2.1 kg/m2, 12 N/mm admissible",
    Evidence.READ,
)
HABASIT_A1 = Source(
    "habasit-a1",
    "Habasit, product data sheet A-1: polyamide machine tape, 1.2 mm, 1.3 kg/m2",
    Evidence.QUOTED,
)
HABASIT_F5 = Source(
    "habasit-f5",
    "Habasit F-5EXWT+H15, figures listed by a dealer (mibelting.com): two-ply polyester conveyor "
    "belt, k1% static 9.5 and relaxed 6.5 N/mm, 1.2 mm, 1.3 kg/m2, -30 to 80 degC, 0.15 on steel",
    Evidence.QUOTED,
)
SIEGLING = Source(
    "siegling",
    "Forbo Siegling, Flat belts: technical information and calculation methods, ref. 316: "
    "temperature range of each line",
    Evidence.READ,
)
NITTA = Source(
    "nitta",
    "Nitta, NittaBeltPoly B-PB-03: polyamide film with NBR covers, up to 70 m/s",
    Evidence.READ,
)
SHIGLEY_FLAT = Source(
    "shigley-17-2",
    "Shigley, Mechanical Engineering Design, Table 17-2, as quoted in worked problems: polyamide "
    "A-3 0.13 in, 0.042 lbf/in3, 100 lbf/in, f 0.8; F-1 0.05 in, f 0.5",
    Evidence.QUOTED,
)
SHIGLEY_METAL = Source(
    "shigley-metal",
    "Shigley, Mechanical Engineering Design, metal flat belts, as quoted in a worked example: "
    "stainless on metal pulleys f 0.35, E 28 Mpsi, Poisson 0.285",
    Evidence.QUOTED,
)
BELT_CONTACT = Source(
    "belt-contact",
    "The contact and friction between flat belts and pulleys (journal abstract): rubber-coated "
    "nylon belts 0.3 to 0.8; real contact under a third of the apparent area",
    Evidence.READ,
)
DURABELT = Source(
    "durabelt",
    "Dura-Belt, physical properties of urethane belting 83A to 92A, and its comparison with "
    "Polycord: modulus at 10 % stretch, friction on steel and aluminium, 8 to 10 % stretch",
    Evidence.READ,
)
MEGAWELD = Source(
    "megaweld",
    "Megadyne, Megaweld catalogue (2016): force of PR 85 round belts of 2 to 20 mm at 8 % stretch",
    Evidence.READ,
)
TPU_DENSITY = Source(
    "tpu-density",
    "Supplier's table of polyether TPU grades 80A to 75D (web page): 1.18 to 1.22 g/cm3",
    Evidence.READ,
)
ELATECH = Source(
    "elatech",
    "Elatech, polyurethane belts: polyurethane on steel 0.7 static, polyamide facing 0.35",
    Evidence.READ,
)
LUST = Source(
    "lust",
    "Lust CDA3000 engineering guide, formula bank, Table 7.21: steel on steel 0.12 to 0.60 static "
    "dry, plastic belt on steel 0.25 to 0.45 static",
    Evidence.READ,
)
DIN_22101 = Source(
    "din-22101",
    "DIN 22101 / ISO 5048, friction of rubber belts on drive pulleys by lagging and surface state: "
    "the bare-steel and polyurethane columns",
    Evidence.MEMORY,
)
DIN_22101_QUOTED = Source(
    "din-22101-quoted",
    "DIN 22101 / ISO 5048 as quoted in a bulk-online.com forum thread: ceramic lagging 0.40 to "
    "0.45 dry, 0.35 to 0.40 clean and wet",
    Evidence.QUOTED,
)
DRIVE_FACTORS = Source(
    "drive-factors",
    "Shiftbulk, table of drive friction factors from CEMA, CMA, Rema Tip Top, Bridgestone, Linatex "
    "and Stephens Adamson catalogues",
    Evidence.QUOTED,
)
BULK_ONLINE = Source(
    "bulk-online",
    "bulk-online.com, Drive pulley to belt friction coefficients (2005): values in use by a "
    "conveyor designer, unlagged, diamond grooved, ceramic",
    Evidence.READ,
)
GB_7984 = Source(
    "gb-7984",
    "GB/T 7984 as quoted by belt makers: elongation of EP and NN belts at reference force (10 % of "
    "strength) at most 4 %; a maker's guide value for EP fabric is 2 %",
    Evidence.QUOTED,
)
EP_MASS = Source(
    "ep-mass",
    "Belt makers' rules: sum of covers times 1.15 kg/m2 per mm (1.4 for heavy rubber, Fenner "
    "Dunlop), plus carcass; EP 125 ply 0.85 mm",
    Evidence.READ,
)
OPTIBELT = Source(
    "optibelt",
    "Optibelt, technical manual for V-belt drives: SK sections (mass, smallest pulley, 42 m/s) and "
    "groove angles to DIN 2211, DIN 2217, ISO 4183",
    Evidence.READ,
)
CONTITECH = Source(
    "contitech",
    "ContiTech, Power Transmission Products, list of dimensions: mass of classical V-belts (DIN "
    "2215), rib pitch, height and mass of V-ribbed belts (DIN 7867)",
    Evidence.READ,
)
PIX = Source(
    "pix",
    "PIX, ribbed industrial V-belts, section PH: -18 to 100 degC, 50 m/s",
    Evidence.READ,
)
WEDGE_LIMITS = Source(
    "wedge-limits",
    "Dealer's page of an SPA wedge belt (simplybearings.co.uk): -20 to 70 degC",
    Evidence.READ,
)
V_EFFECTIVE = Source(
    "v-effective",
    "Effective friction of a V-belt in its groove: 0.5123 for design (Engineers Edge, after "
    "Shigley/Gates), 1.0 to 2.0 observed (PTI glossary)",
    Evidence.QUOTED,
)
WET_RIBS = Source(
    "wet-ribs",
    "Sheng et al. 2011, Experimental characterization and analysis of wet belt friction "
    "(abstract): wet kinetic friction of ribbed belts 30 to 40 % below dry",
    Evidence.READ,
)
V_RIBBED_STANDARD = Source(
    "iso-9981",
    "ISO 9981 / ISO 9982 / DIN 7867: groove angle 40 deg of V-ribbed pulleys",
    Evidence.MEMORY,
)
KIM_LEAMY_FERRI = Source(
    "kim-2011",
    "Kim, Leamy, Ferri 2011, DOI 10.1115/1.4003796, Table 1: EA 80,068 N at 0.1036 kg/m, kf "
    "8.1e7 N/m2, mu 1.2",
    Evidence.READ,
)
BEIKMANN = Source(
    "beikmann",
    "Beikmann, Perkins, Ulsoy 1996, serpentine drives: EA 170 kN at 0.1029 kg/m",
    Evidence.MEMORY,
)
CORD = Source(
    "cord",
    "Cord layer: polyester cord of 8 GPa filling 65 % of datum width times cord diameter",
    Evidence.ESTIMATE,
)
RUBBER = Source(
    "rubber",
    "Shear modulus of filled rubber of 55 to 80 Shore A, 0.7 to 3 MPa, from rubber handbooks",
    Evidence.MEMORY,
)
CATALOGUES = Source(
    "catalogues",
    "Common range of manufacturers' catalogues (Habasit, Siegling, Ammeraal, Nitta, Sandvik)",
    Evidence.MEMORY,
)
SHEAR = Source(
    "shear",
    "Shear of the layer between tension member and pulley, G/t, after Firbank 1970, Mechanics of "
    "the belt drive; a factor of three either way for contact and dynamic stiffening",
    Evidence.DERIVED,
)
ESTIMATE = Source("estimate", "Typical, unverified", Evidence.ESTIMATE)

SOURCES: tuple[Source, ...] = tuple(
    value for value in list(globals().values()) if isinstance(value, Source)
)
